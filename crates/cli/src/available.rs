//! How much memory there is for this program: what the system has left, and what its control group allows.

use std::fs;
use std::path::{Path, PathBuf};

/// Bytes that are available; `None` where the system does not say.
pub(crate) fn memory() -> Option<u64> {
    below(Path::new("/"))
}

/// The same for a system whose files lie below a folder.
fn below(root: &Path) -> Option<u64> {
    let system = fs::read_to_string(root.join("proc/meminfo")).ok().and_then(|text| kib(&text, "MemAvailable:"));
    let groups = fs::read_to_string(root.join("proc/self/cgroup")).unwrap_or_default();
    let allowed = groups.lines().filter_map(|line| group(root, line)).min();
    [system, allowed].into_iter().flatten().min()
}

/// What is left of a control group and of those around it, by a line such as `0::/a/b` or `5:memory:/a/b`.
fn group(root: &Path, line: &str) -> Option<u64> {
    let mut parts = line.splitn(3, ':').skip(1);
    let (controllers, path) = (parts.next()?, parts.next()?);
    let (mount, limit, used, cache) = match controllers {
        "" => ("sys/fs/cgroup", "memory.max", "memory.current", "inactive_file"),
        c if c.split(',').any(|c| c == "memory") => {
            ("sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        }
        _ => return None,
    };
    let mount = root.join(mount);
    let own = mount.join(path.trim_start_matches('/'));
    // Inside of a container its group is mounted as the root, whatever it is called outside.
    let folders = if own.is_dir() { own.ancestors().map(PathBuf::from).collect() } else { vec![mount.clone()] };
    let left = |folder: &PathBuf| {
        let number = |name: &str| fs::read_to_string(folder.join(name)).ok()?.trim().parse::<u64>().ok();
        let stat = fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
        // Pages of files are given back when memory is short.
        let given_back = value(&stat, cache).unwrap_or(0);
        Some(number(limit)?.saturating_sub(number(used)?.saturating_sub(given_back)))
    };
    folders.iter().take_while(|folder| folder.starts_with(&mount)).filter_map(left).min()
}

/// The number after a name at the start of a line.
fn value(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

fn kib(text: &str, name: &str) -> Option<u64> {
    value(text, name).map(|kib| kib.saturating_mul(1024))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A system of these files.
    fn system(name: &str, files: &[(&str, &str)]) -> Option<u64> {
        let root = std::env::temp_dir().join(format!("selvedge-available-{}-{name}", std::process::id()));
        for (file, text) in files {
            let path = root.join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let found = below(&root);
        let _ = fs::remove_dir_all(&root);
        found
    }

    const MEMINFO: (&str, &str) = ("proc/meminfo", "MemTotal:  9000 kB\nMemAvailable:     8000 kB\n");

    #[test]
    fn the_tightest_bound_counts() {
        assert_eq!(system("none", &[]), None);
        assert_eq!(system("plain", &[MEMINFO]), Some(8000 * 1024));
        let v2 = [
            MEMINFO,
            ("proc/self/cgroup", "0::/a/b\n"),
            ("sys/fs/cgroup/a/memory.max", "1000000\n"),
            ("sys/fs/cgroup/a/memory.current", "400000\n"),
            ("sys/fs/cgroup/a/memory.stat", "anon 1\ninactive_file 100000\n"),
            ("sys/fs/cgroup/a/b/memory.max", "max\n"),
            ("sys/fs/cgroup/a/b/memory.current", "1\n"),
        ];
        assert_eq!(system("v2", &v2), Some(700_000), "the group around this one is the tight one");
    }

    #[test]
    fn containers_and_the_first_version_are_understood() {
        let v2 = [
            ("proc/self/cgroup", "0::/outside/name\n"),
            ("sys/fs/cgroup/memory.max", "500"),
            ("sys/fs/cgroup/memory.current", "600"),
        ];
        assert_eq!(system("container", &v2), Some(0));
        let v1 = [
            MEMINFO,
            ("proc/self/cgroup", "9:cpu,cpuacct:/a\n5:memory:/a\n"),
            ("sys/fs/cgroup/memory/a/memory.limit_in_bytes", "3000\n"),
            ("sys/fs/cgroup/memory/a/memory.usage_in_bytes", "1000\n"),
        ];
        assert_eq!(system("v1", &v1), Some(2000));
    }
}
