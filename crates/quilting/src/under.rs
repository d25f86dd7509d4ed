//! What lies under a block, as the search wants it.

use selvedge_core::{Domain, Exemplars, Guide, SourceMap, reserve};
use selvedge_fft_ssd::Template;

use crate::block_grid::Block;
use crate::options::Error;

/// Features under a block, and where there are any to compare with. Its memory serves block after block.
#[derive(Clone, Debug, Default)]
pub(crate) struct Under {
    /// Height and width.
    pub(crate) shape: [u32; 2],
    /// Channel by channel, each row-major; meaningless where `mask` is false.
    pub(crate) features: Vec<u8>,
    /// Row-major: what is compared.
    pub(crate) mask: Vec<bool>,
}

impl Under {
    /// One that takes no more memory for blocks up to this side.
    pub(crate) fn for_blocks(side: u32, exemplars: &Exemplars<2>) -> Result<Self, Error> {
        let samples = side as usize * side as usize;
        let mut under = Self::default();
        under.clear(samples, exemplars.channels())?;
        Ok(under)
    }

    /// Takes the features of a map's samples under a block where they are compared.
    pub(crate) fn read(
        &mut self,
        exemplars: &Exemplars<2>,
        map: &SourceMap<2>,
        block: &Block,
        compared: impl Fn([u32; 2]) -> bool,
    ) -> Result<(), Error> {
        let (output, table) = (map.domain(), exemplars.table());
        self.shape = block.shape();
        let n = (self.shape[0] * self.shape[1]) as usize;
        self.clear(n, exemplars.channels())?;
        self.features.resize(n * exemplars.channels(), 0);
        for (i, p) in Domain::open(self.shape).positions().enumerate() {
            let id = compared(p).then(|| map.ids.get(0, block.position(output, p)));
            let source = id.and_then(|id| table.source(id));
            self.mask.push(source.is_some());
            if let (Some(source), Some(id)) = (source, id) {
                let from = (id.get() - table.first(source)) as usize;
                let features = &exemplars.sources()[source].features;
                for c in 0..features.channels() {
                    self.features[c * n + i] = features.plane(c)[from];
                }
            }
        }
        Ok(())
    }

    /// Empties the buffers and makes room for so many samples and channels.
    pub(crate) fn clear(&mut self, samples: usize, channels: usize) -> Result<(), Error> {
        self.mask.clear();
        self.features.clear();
        reserve(&mut self.mask, samples)?;
        Ok(reserve(&mut self.features, samples * channels)?)
    }

    /// What is compared, for the search.
    pub(crate) fn template(&self) -> Template<'_, 2> {
        Template::new(self.shape, &self.features).masked(&self.mask)
    }

    /// Compared samples.
    pub(crate) fn samples(&self) -> u64 {
        self.mask.iter().filter(|&&on| on).count() as u64
    }

    /// Takes the guide's target under a block.
    pub(crate) fn read_target(&mut self, guide: &Guide<2>, block: &Block) -> Result<(), Error> {
        let target = guide.target();
        self.shape = block.shape();
        let samples = (self.shape[0] * self.shape[1]) as usize;
        self.clear(samples, target.channels())?;
        for c in 0..target.channels() {
            let under = |p| target.get(c, block.position(target.domain(), p));
            self.features.extend(Domain::open(self.shape).positions().map(under));
        }
        match guide.asked() {
            None => self.mask.resize(samples, true),
            Some(asked) => {
                let under = |p| asked.get(0, block.position(asked.domain(), p));
                self.mask.extend(Domain::open(self.shape).positions().map(under));
            }
        }
        Ok(())
    }
}
