//! Which channels of a file make the picture.

use exr::math::Vec2;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;

use crate::Format;
use crate::error::Problem;
use crate::name::escaped;

/// Channels of one part, in the order of the picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Selection {
    pub(super) part: usize,
    /// Their places among the part's channels.
    pub(super) channels: Vec<usize>,
    pub(super) alpha: bool,
}

/// One channel of a file: `part` and `layer` are empty where there is none.
struct Channel {
    part: usize,
    place: usize,
    part_name: String,
    /// As stored: `layer.R`.
    stored: String,
    /// Whether it can be read as a picture.
    is_read: bool,
}

impl Channel {
    fn layer(&self) -> &str {
        self.stored.rsplit_once('.').map_or("", |(layer, _)| layer)
    }

    fn base(&self) -> &str {
        self.stored.rsplit_once('.').map_or(&self.stored, |(_, base)| base)
    }

    /// How messages name it, and how it may be asked for.
    fn full(&self) -> String {
        if self.part_name.is_empty() { self.stored.clone() } else { format!("{}.{}", self.part_name, self.stored) }
    }
}

/// All channels, as they may be asked for.
pub(super) fn names(parts: &[Header]) -> Vec<String> {
    channels(parts).iter().map(Channel::full).collect()
}

/// Names of what is not in a picture that nobody chose, and how it is read; `None` if nothing is.
pub(super) fn left_out(parts: &[Header], chosen: &Selection) -> Option<String> {
    let is_chosen = |c: &&Channel| c.part == chosen.part && chosen.channels.contains(&c.place);
    let all = channels(parts);
    let others: Vec<&Channel> = all.iter().filter(|c| !is_chosen(c)).collect();
    let name = |c: &&Channel| shortened(&escaped(c.full().as_bytes()));
    let first: Vec<String> = others.iter().take(NAMES).map(name).collect();
    let more = others.len() - first.len();
    let more = if more == 0 { String::new() } else { format!(" and {more} more") };
    let reads = others.iter().find(|c| c.is_read).map(|c| {
        let which = match others.len() {
            1 => "it",
            _ if name(c) == first[0] => "the first",
            _ => "that one",
        };
        format!("; 'file.exr[{}]' reads {which}", name(c))
    });
    let reads = reads.unwrap_or_else(|| " (32-bit integers, deep or subsampled, which are not read)".to_owned());
    (!others.is_empty()).then(|| format!("not in the picture: {}{more}{reads}", first.join(", ")))
}

/// Names of channels in one message, and signs of one name: a file may have thousands of any length.
const NAMES: usize = 4;
const SIGNS: usize = 60;

fn shortened(name: &str) -> String {
    if name.chars().count() <= SIGNS {
        name.to_owned()
    } else {
        name.chars().take(SIGNS).chain("...".chars()).collect()
    }
}

fn channels(parts: &[Header]) -> Vec<Channel> {
    let mut all = Vec::new();
    for (part, header) in parts.iter().enumerate() {
        // The name of the only part says nothing.
        let named = 1 < parts.len();
        let part_name = header.own_attributes.layer_name.as_ref().filter(|_| named).map(ToString::to_string);
        for (place, channel) in header.channels.list.iter().enumerate() {
            let part_name = part_name.clone().unwrap_or_default();
            let is_read = !header.deep && channel.sample_type != SampleType::U32 && channel.sampling == Vec2(1, 1);
            all.push(Channel { part, place, part_name, stored: channel.name.to_string(), is_read });
        }
    }
    all
}

/// What was asked for, or the colour outside of layers, or that of the only layer, or the only channel.
pub(super) fn select(parts: &[Header], wanted: Option<&str>) -> Result<Selection, Problem> {
    let all = channels(parts);
    let chosen = match wanted {
        Some(wanted) => by_name(&all, wanted).or_else(|| by_layer(&all, wanted)),
        None => default(&all),
    };
    let chosen = chosen.ok_or_else(|| Problem::NoChannel {
        wanted: wanted.map_or("default picture".to_owned(), |w| format!("layer or channels '{w}'")),
        found: all.iter().map(Channel::full).collect::<Vec<_>>().join(", "),
    })?;
    check(&parts[chosen.part], &chosen)?;
    Ok(chosen)
}

/// `R,G,B` or one channel's name.
fn by_name(all: &[Channel], wanted: &str) -> Option<Selection> {
    let find = |name: &str, part: Option<usize>| {
        all.iter().find(|c| part.is_none_or(|p| p == c.part) && (c.full() == name || c.stored == name))
    };
    let mut names = wanted.split(',').map(str::trim);
    let first = find(names.next()?, None)?;
    let mut channels = vec![first.place];
    let mut last = first;
    for name in names {
        last = find(name, Some(first.part))?;
        channels.push(last.place);
    }
    let alpha = 1 < channels.len() && last.base() == "A";
    Some(Selection { part: first.part, channels, alpha })
}

/// All of a layer: a part's name, a prefix of channels, or both.
fn by_layer(all: &[Channel], wanted: &str) -> Option<Selection> {
    let part = all.iter().filter(|c| c.part_name == wanted);
    let with_part = |c: &Channel| c.full().rsplit_once('.').is_some_and(|(layer, _)| layer == wanted);
    let layer = all.iter().filter(|c| c.layer() == wanted || with_part(c));
    arrange(part).or_else(|| arrange(layer))
}

fn default(all: &[Channel]) -> Option<Selection> {
    let parts = all.iter().map(|c| c.part).max()? + 1;
    let plain = |part| arrange_color(all.iter().filter(move |c| c.part == part && c.layer().is_empty()));
    let first = all.first()?;
    let one_layer = all.iter().all(|c| c.part == first.part && c.layer() == first.layer());
    let known = || arrange_color(all.iter()).or_else(|| if all.len() == 1 { arrange(all.iter()) } else { None });
    (0..parts).find_map(plain).or_else(|| if one_layer { known() } else { None })
}

/// Known colours in their order, else everything, alpha last.
fn arrange<'a>(layer: impl Iterator<Item = &'a Channel> + Clone) -> Option<Selection> {
    arrange_color(layer.clone()).or_else(|| {
        let part = layer.clone().next()?.part;
        let mut chosen: Vec<&Channel> = layer.filter(|c| c.part == part).collect();
        chosen.sort_by_key(|c| c.base() == "A");
        let alpha = 1 < chosen.len() && chosen.last()?.base() == "A";
        Some(Selection { part, channels: chosen.iter().map(|c| c.place).collect(), alpha })
    })
}

fn arrange_color<'a>(layer: impl Iterator<Item = &'a Channel> + Clone) -> Option<Selection> {
    let find = |base: &str| layer.clone().find(|c| c.base().eq_ignore_ascii_case(base));
    for set in [&["R", "G", "B"][..], &["X", "Y", "Z"], &["X", "Y"], &["Y"]] {
        let found: Option<Vec<&Channel>> = set.iter().map(|base| find(base)).collect();
        let Some(mut found) = found.filter(|f| f.iter().all(|c| c.part == f[0].part)) else { continue };
        let alpha = find("A").filter(|a| a.part == found[0].part);
        found.extend(alpha);
        let channels = found.iter().map(|c| c.place).collect();
        return Some(Selection { part: found[0].part, channels, alpha: alpha.is_some() });
    }
    None
}

/// What cannot be read as samples side by side.
fn check(part: &Header, chosen: &Selection) -> Result<(), Problem> {
    let unsupported = |what: &str| Err(Problem::unsupported(Format::Exr, what));
    let list = &part.channels.list;
    if part.deep {
        return unsupported("deep data");
    }
    if list.iter().any(|c| c.sampling.0 != 1 || c.sampling.1 != 1) {
        return unsupported("subsampled channels");
    }
    if chosen.channels.iter().any(|c| list[*c].sample_type == SampleType::U32) {
        return unsupported("a picture of 32-bit integers");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(part: usize, part_name: &str, place: usize, stored: &str) -> Channel {
        Channel { part, place, part_name: part_name.into(), stored: stored.into(), is_read: true }
    }

    fn file(names: &[&str]) -> Vec<Channel> {
        names.iter().enumerate().map(|(i, name)| channel(0, "", i, name)).collect()
    }

    fn places(selection: Option<Selection>) -> Option<(Vec<usize>, bool)> {
        selection.map(|s| (s.channels, s.alpha))
    }

    #[test]
    fn colour_comes_first() {
        assert_eq!(places(default(&file(&["A", "B", "G", "R", "Z"]))), Some((vec![3, 2, 1, 0], true)));
        assert_eq!(places(default(&file(&["Y"]))), Some((vec![0], false)));
        assert_eq!(places(default(&file(&["X", "Y", "Z"]))), Some((vec![0, 1, 2], false)));
        assert_eq!(places(default(&file(&["n.X", "n.Y", "n.Z"]))), Some((vec![0, 1, 2], false)));
        assert_eq!(places(default(&file(&["depth"]))), Some((vec![0], false)));
        assert_eq!(places(default(&file(&["R", "Z"]))), None);
        assert_eq!(places(default(&file(&["a.B", "a.G", "a.R", "b.Y"]))), None);
    }

    #[test]
    fn layers_and_channels_by_name() {
        let all = file(&["A", "B", "G", "R", "diffuse.B", "diffuse.G", "diffuse.R", "depth.Z"]);
        let named = |wanted: &str| places(by_name(&all, wanted).or_else(|| by_layer(&all, wanted)));
        assert_eq!(named("diffuse"), Some((vec![6, 5, 4], false)));
        assert_eq!(named("depth"), Some((vec![7], false)));
        assert_eq!(named("B, R"), Some((vec![1, 3], false)));
        assert_eq!(named("R,A"), Some((vec![3, 0], true)));
        assert_eq!(named("diffuse.G"), Some((vec![5], false)));
        assert_eq!(named("nothing"), None);
        assert_eq!(named("R,nothing"), None);
    }

    #[test]
    fn parts_are_layers_too() {
        let all = vec![
            channel(0, "left", 0, "Y"),
            channel(1, "right", 0, "B"),
            channel(1, "right", 1, "G"),
            channel(1, "right", 2, "R"),
            channel(1, "right", 3, "n.X"),
        ];
        let named = |wanted: &str| by_name(&all, wanted).or_else(|| by_layer(&all, wanted));
        assert_eq!(default(&all), Some(Selection { part: 0, channels: vec![0], alpha: false }));
        assert_eq!(named("right"), Some(Selection { part: 1, channels: vec![2, 1, 0], alpha: false }));
        assert_eq!(named("right.G"), Some(Selection { part: 1, channels: vec![1], alpha: false }));
        assert_eq!(named("right.n"), Some(Selection { part: 1, channels: vec![3], alpha: false }));
        assert_eq!(named("left.Y,right.G"), None, "channels of two parts may differ in size");
    }
}
