//! The paper's search: a tree of clusters of clusters. `[Kwatra05 3]`
//!
//! It finds what is near, and mostly not what is nearest; the search by displacement finds that, and sooner. It is here
//! to be compared with.

use selvedge_core::{Exemplars, Grid, par};
use selvedge_fft_ssd::Neighbor;

use super::coherent::Listed;
use crate::assignment::Place;
use crate::neighborhoods::{Neighborhoods, places};

/// Clusters of a node. `[Kwatra05 3]`
const BRANCHES: usize = 4;
/// A node of fewer than this part of all is a leaf. `[Kwatra05 3]`
const LEAVES: usize = 100;
/// Times that means follow their clusters. The paper says none; after these few hardly a place changes its cluster.
const ROUNDS: usize = 6;

/// Places of the exemplars, near ones together. What they show is looked up when it is asked for: leaves hold places
/// alone, nodes the means of what their clusters show.
#[derive(Debug)]
pub(super) struct Tree {
    root: Node,
    /// Square roots of the channels' weights.
    scales: Vec<f32>,
}

#[derive(Debug)]
enum Node {
    Leaf(Vec<Place>),
    Clusters(Vec<(Vec<f32>, Node)>),
}

impl Tree {
    /// Of all places at which a neighborhood can stand.
    ///
    /// Time `O(places * log(places) * size^2 * channels)`, space that of places and of some hundreds of neighborhoods.
    pub(super) fn new(exemplars: &Exemplars<2>, weights: &[u8], size: u32) -> Self {
        let of = |(source, s)| places(s, size).map(move |at| Place { source, at });
        let all: Vec<Place> = (0..).zip(exemplars.sources().iter().map(AsRef::as_ref)).flat_map(of).collect();
        let scales: Vec<f32> = weights.iter().map(|&weight| f32::from(weight).sqrt()).collect();
        let shows = Shows { exemplars, scales: &scales, size };
        let least = all.len().div_ceil(LEAVES).max(2);
        Self { root: shows.node(all, least), scales }
    }

    /// The nearest of a leaf, that of the nearest cluster at each node.
    pub(super) fn nearest(
        &self,
        (all, number): (&Neighborhoods, usize),
        seen: &Grid<u8, 2>,
        listed: &Listed<'_>,
    ) -> Option<Neighbor> {
        let shown = window(seen, (all.first(number), all.size), &self.scales);
        let mut node = &self.root;
        loop {
            match node {
                Node::Leaf(places) => return listed.best(seen, number, places, |_, error| error as f64),
                Node::Clusters(clusters) => node = &clusters[nearest(&shown, clusters.iter().map(|c| &c.0))].1,
            }
        }
    }
}

/// What exemplars show at places.
struct Shows<'a> {
    exemplars: &'a Exemplars<2>,
    scales: &'a [f32],
    size: u32,
}

impl Shows<'_> {
    fn node(&self, all: Vec<Place>, least: usize) -> Node {
        if all.len() < least.max(BRANCHES) {
            return Node::Leaf(all);
        }
        // Beginning with some of them, one of each fourth: what is drawn makes no better trees.
        let mut means: Vec<Vec<f32>> =
            (0..BRANCHES).map(|i| self.at(all[(2 * i + 1) * all.len() / (2 * BRANCHES)])).collect();
        let mut clusters = self.clusters(&all, &means);
        for _ in 1..ROUNDS {
            means = self.means(&all, (&clusters, means));
            let now = self.clusters(&all, &means);
            if now == clusters {
                break;
            }
            clusters = now;
        }
        let mut parts: Vec<Vec<Place>> = vec![Vec::new(); BRANCHES];
        clusters.iter().zip(&all).for_each(|(&cluster, &place)| parts[cluster].push(place));
        // All alike.
        if parts.iter().any(|part| part.len() == all.len()) {
            return Node::Leaf(all);
        }
        let parts = means.into_iter().zip(parts).filter(|(_, part)| !part.is_empty());
        Node::Clusters(parts.map(|(mean, part)| (mean, self.node(part, least))).collect())
    }

    fn clusters(&self, all: &[Place], means: &[Vec<f32>]) -> Vec<usize> {
        par::map_indexed(all.len(), |i| nearest(&self.at(all[i]), means.iter()))
    }

    /// Of what clusters show; that from before of one that has nothing.
    fn means(&self, all: &[Place], (clusters, before): (&[usize], Vec<Vec<f32>>)) -> Vec<Vec<f32>> {
        par::map_indexed(before.len(), |cluster| {
            let of = clusters.iter().zip(all).filter(|(own, _)| **own == cluster);
            let (mut sum, mut n) = (vec![0.0_f64; before[cluster].len()], 0.0);
            for (_, &place) in of {
                n += 1.0;
                sum.iter_mut().zip(self.at(place)).for_each(|(sum, v)| *sum += f64::from(v));
            }
            if n == 0.0 { before[cluster].clone() } else { sum.into_iter().map(|v| (v / n) as f32).collect() }
        })
    }

    fn at(&self, Place { source, at }: Place) -> Vec<f32> {
        window(&self.exemplars.sources()[source as usize].features, (at, self.size), self.scales)
    }
}

/// The samples of a square, around periodic axes, by which distances are those of the search.
fn window(features: &Grid<u8, 2>, (at, size): ([u32; 2], u32), scales: &[f32]) -> Vec<f32> {
    let [rows, columns] = features.domain().shape;
    let mut shown = Vec::with_capacity(scales.len() * (size * size) as usize);
    for (c, &scale) in scales.iter().enumerate() {
        for y in 0..size {
            let row = (at[0] + y) % rows;
            let from = features.domain().index([row, 0]);
            let row = &features.plane(c)[from..][..columns as usize];
            shown.extend((0..size).map(|x| scale * f32::from(row[((at[1] + x) % columns) as usize])));
        }
    }
    shown
}

/// The first of the nearest means.
fn nearest<'a>(shown: &[f32], means: impl Iterator<Item = &'a Vec<f32>>) -> usize {
    let distance = |mean: &Vec<f32>| shown.iter().zip(mean).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
    let mut best = (f32::INFINITY, 0);
    for (i, mean) in means.enumerate() {
        let distance = distance(mean);
        if distance < best.0 {
            best = (distance, i);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::{Exact, How};
    use crate::testing::{exemplars, output};
    use selvedge_core::{Rng, Seed, SimdLevel};

    /// A part of the exemplars with noise on it: what is nearest is mostly clear.
    fn picture(rng: &mut Rng, exemplars: &Exemplars<2>, all: &Neighborhoods) -> Grid<f64, 2> {
        let features = &exemplars.sources()[0].features;
        let shape = features.domain().shape;
        let mut x = Grid::try_filled(all.domain, 2, 0.0).unwrap();
        for c in 0..2 {
            for at in all.domain.positions() {
                let value = f64::from(features.get(c, [0, 1].map(|a| (at[a] + 3) % shape[a])));
                x.set(c, at, value + f64::from(rng.below(41)) - 20.0);
            }
        }
        x
    }

    #[test]
    fn a_tree_finds_what_is_near_and_often_what_is_nearest() {
        let (mut recalled, mut asked, mut far) = (0, 0, 0.0);
        for case in 0..12 {
            let mut rng = Seed(case).derive("tree", 0).rng();
            let size = [8, 12][case as usize % 2];
            let exemplars = exemplars(&mut rng, [40, 44], true);
            let all = Neighborhoods::new(output(&mut rng, size), size);
            let x = picture(&mut rng, &exemplars, &all);
            let found = |tree| {
                let how = How { tree, ..How::default() };
                Exact::new(&exemplars, &all, how, SimdLevel::Auto).search(&x).unwrap().unwrap()
            };
            let (near, nearest) = (found(true), found(false));
            assert!(near.distances.iter().zip(&nearest.distances).all(|(a, b)| b <= a));
            recalled += near.places.iter().zip(&nearest.places).filter(|(a, b)| a == b).count();
            asked += all.len();
            let sum = |distances: &[f64]| distances.iter().sum::<f64>();
            far += sum(&near.distances) / sum(&nearest.distances) / 12.0;
        }
        let recall = recalled as f64 / asked as f64;
        assert!((0.7..1.0).contains(&recall) && far < 1.1, "{recall} of the nearest, {far} times as far");
    }

    #[test]
    fn leaves_hold_all_places_once_and_few_each() {
        let mut rng = Seed(3).rng();
        let exemplars = exemplars(&mut rng, [40, 44], true);
        let tree = Tree::new(&exemplars, exemplars.weights(), 8);
        let (mut held, mut nodes) = (Vec::<Place>::new(), vec![&tree.root]);
        let of = |(source, s)| places(s, 8).map(move |at| Place { source, at });
        let all: Vec<Place> = (0..).zip(exemplars.sources().iter().map(AsRef::as_ref)).flat_map(of).collect();
        while let Some(node) = nodes.pop() {
            match node {
                Node::Leaf(places) => {
                    assert!(places.len() < all.len().div_ceil(100), "{}", places.len());
                    held.extend(places);
                }
                Node::Clusters(clusters) => nodes.extend(clusters.iter().map(|(_, node)| node)),
            }
        }
        held.sort_by_key(|place| (place.source, place.at));
        assert_eq!(held, all);
    }
}
