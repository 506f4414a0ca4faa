//! Files that a file names: they must lie in its folder.
//!
//! What comes from elsewhere must not read other files of this machine, so whatever leaves the folder is refused,
//! be it by the name or by a link.

use std::path::{Component, Path, PathBuf};

/// Why a name is not that of a file in the folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stray {
    /// It is empty or holds a zero.
    NoName,
    /// It is an address, or a path of another system.
    Address,
    /// It leads out of the folder.
    Leaves,
    /// A link leads out of the folder.
    LeavesByLink,
    /// There is no such file.
    Missing,
}

impl Stray {
    /// The same as a clause about the name.
    pub(crate) fn clause(self) -> &'static str {
        match self {
            Self::NoName => "which is not a name",
            Self::Address => "which is an address or a path of another system",
            Self::Leaves => "which leaves its folder",
            Self::LeavesByLink => "which leaves its folder by a link",
            Self::Missing => "which is not there",
        }
    }
}

/// The file of `folder` with this name, links followed.
pub(crate) fn inside(folder: &Path, name: &str) -> Result<PathBuf, Stray> {
    if name.is_empty() || name.contains('\0') {
        return Err(Stray::NoName);
    }
    if name.contains(':') || name.contains('\\') {
        return Err(Stray::Address);
    }
    let relative = Path::new(name);
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if !relative.components().all(plain) {
        return Err(Stray::Leaves);
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let real = |path: &Path| path.canonicalize().map_err(|_| Stray::Missing);
    let (home, path) = (real(here)?, real(&here.join(relative))?);
    if path.starts_with(&home) { Ok(path) } else { Err(Stray::LeavesByLink) }
}
