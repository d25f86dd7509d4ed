//! Bytes of what is kept for another run: whole numbers of eight bytes, of samples four, the least byte first.

use selvedge_core::SampleId;

/// What is left of them.
pub(crate) struct Words<'a>(pub(crate) &'a [u8]);

impl Words<'_> {
    pub(crate) fn word(&mut self) -> Option<u64> {
        let (first, others) = self.0.split_first_chunk::<8>()?;
        self.0 = others;
        Some(u64::from_le_bytes(*first))
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Option<[u64; N]> {
        let mut all = [0; N];
        for word in &mut all {
            *word = self.word()?;
        }
        Some(all)
    }

    /// So many words, by their number in front of them.
    pub(crate) fn prices(&mut self) -> Option<Vec<i64>> {
        (0..self.word()?).map(|_| Some(self.word()? as i64)).collect()
    }

    /// The samples that all ends with, of which there must be so many.
    pub(crate) fn ids(&self, samples: u64) -> Option<Vec<SampleId>> {
        let (ids, others) = self.0.as_chunks::<4>();
        let ids = (others.is_empty() && ids.len() as u64 == samples).then_some(ids)?;
        Some(ids.iter().map(|id| SampleId::new(u32::from_le_bytes(*id))).collect())
    }
}

pub(crate) fn put_word(bytes: &mut Vec<u8>, word: u64) {
    bytes.extend(word.to_le_bytes());
}

pub(crate) fn put_prices(bytes: &mut Vec<u8>, prices: &[i64]) {
    put_word(bytes, prices.len() as u64);
    prices.iter().for_each(|price| put_word(bytes, *price as u64));
}

pub(crate) fn put_ids(bytes: &mut Vec<u8>, ids: &[SampleId]) {
    bytes.extend(ids.iter().flat_map(|id| id.get().to_le_bytes()));
}
