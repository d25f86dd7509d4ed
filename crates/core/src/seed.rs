//! Randomness that is keyed by what is decided, so that threads and call order never change a result.

/// The seed of a run, or of one decision in it.
///
/// [`derive`](Self::derive) names the decision (a stage and an index); [`rng`](Self::rng) draws for it.
/// Deriving is SplitMix64 (Steele, Lea, Flood 2014), drawing is xoshiro256++ (Blackman, Vigna 2019).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seed(pub u64);

impl Seed {
    /// The seed of decision number `index` of a stage such as `"quilting/block"`.
    #[must_use]
    pub fn derive(self, stage: &'static str, index: u64) -> Seed {
        // FNV-1a: the stage's name only has to be told from the others.
        let name = stage
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |h: u64, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3));
        let mut state = self.0;
        let mut mixed = splitmix64(&mut state) ^ name;
        mixed = splitmix64(&mut mixed) ^ index;
        Seed(splitmix64(&mut mixed))
    }

    /// A generator that starts from this seed.
    pub fn rng(self) -> Rng {
        let mut state = self.0;
        Rng(std::array::from_fn(|_| splitmix64(&mut state)))
    }
}

fn splitmix64(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// xoshiro256++: 256 bits of state, 64 bits a draw.
#[derive(Clone, Debug)]
pub struct Rng([u64; 4]);

impl Rng {
    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        let s = &mut self.0;
        let drawn = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let t = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= t;
        s[3] = s[3].rotate_left(45);
        drawn
    }

    /// A uniform number in `0..n`, without bias.
    ///
    /// # Panics
    /// If `n` is 0.
    pub fn below(&mut self, n: u32) -> u32 {
        self.below_u64(u64::from(n)) as u32
    }

    /// A uniform number in `0..n`, without bias.
    ///
    /// # Panics
    /// If `n` is 0.
    pub fn below_u64(&mut self, n: u64) -> u64 {
        assert!(0 < n, "nothing lies below 0");
        // The draws under `2^64 mod n` would make the small numbers likelier (Lemire 2019).
        let reject = n.wrapping_neg() % n;
        loop {
            let product = u128::from(self.next_u64()) * u128::from(n);
            if reject <= product as u64 {
                return (product >> 64) as u64;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published reference outputs of SplitMix64 from seed 1234567.
    #[test]
    fn splitmix64_follows_the_published_vector() {
        let mut state = 1_234_567;
        let drawn: [u64; 5] = std::array::from_fn(|_| splitmix64(&mut state));
        let published = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
            4_593_380_528_125_082_431,
            16_408_922_859_458_223_821,
        ];
        assert_eq!(drawn, published);
    }

    /// The published reference outputs of xoshiro256++ from state 1, 2, 3, 4.
    #[test]
    fn xoshiro_follows_the_published_vector() {
        let mut rng = Rng([1, 2, 3, 4]);
        let drawn: [u64; 10] = std::array::from_fn(|_| rng.next_u64());
        let published = [
            41_943_041,
            58_720_359,
            3_588_806_011_781_223,
            3_591_011_842_654_386,
            9_228_616_714_210_784_205,
            9_973_669_472_204_895_162,
            14_011_001_112_246_962_877,
            12_406_186_145_184_390_807,
            15_849_039_046_786_891_736,
            10_450_023_813_501_588_000,
        ];
        assert_eq!(drawn, published);
    }

    #[test]
    fn decisions_are_independent_of_order() {
        let seed = Seed(7);
        assert_eq!(seed.derive("a", 1), seed.derive("a", 1));
        let all = [seed.derive("a", 1), seed.derive("a", 2), seed.derive("b", 1), Seed(8).derive("a", 1)];
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a != b));
        }
    }

    #[test]
    fn below_is_in_range_and_even() {
        let mut rng = Seed(3).rng();
        let mut counts = [0_u32; 6];
        for _ in 0..60_000 {
            counts[rng.below(6) as usize] += 1;
        }
        // Five standard deviations of a binomial with n = 60,000 and p = 1/6.
        assert!(counts.iter().all(|&c| c.abs_diff(10_000) < 457), "{counts:?}");
        assert_eq!(rng.below(1), 0);
    }
}
