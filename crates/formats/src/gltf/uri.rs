//! What a glTF document names beside itself: data in the name, or a file of its own folder.

use crate::error::Fault;
use crate::folder::{self, Stray};
use crate::input;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::path::{Path, PathBuf};

/// Longest part of a name that a message quotes, in characters.
const LONGEST_QUOTE: usize = 60;

/// The bytes that `uri` stands for; `owner` is what names it, `folder` where the document lies.
pub(super) fn read(uri: &str, owner: &str, folder: &Path) -> Result<Vec<u8>, Fault> {
    if let Some(data) = uri.strip_prefix("data:") {
        return decode(data, owner);
    }
    let path = inside(uri, owner, folder)?;
    input::read_whole(&path).map_err(|error| {
        let what = format!("{owner} names a file that cannot be read: {error}");
        Fault::whole(what, "put it beside the document")
    })
}

/// What follows `data:`.
fn decode(data: &str, owner: &str) -> Result<Vec<u8>, Fault> {
    let text = data.split_once(',').filter(|(kind, _)| kind.ends_with(";base64"));
    let bytes = text.and_then(|(_, text)| STANDARD.decode(text).ok());
    bytes.ok_or_else(|| {
        Fault::whole(format!("{owner} holds data that is not base64"), "export it again")
    })
}

/// The file of `folder` that `uri` names.
fn inside(uri: &str, owner: &str, folder: &Path) -> Result<PathBuf, Fault> {
    let name = percent_decoded(uri).ok_or(Stray::NoName);
    name.and_then(|name| folder::inside(folder, &name)).map_err(|stray| {
        let quoted: String = uri.chars().take(LONGEST_QUOTE).collect();
        Fault::whole(
            format!("{owner} names {quoted:?}, {}", stray.clause()),
            "a glTF document may only name files of its own folder: put the file there",
        )
    })
}

/// The name with each `%41` replaced by the byte it stands for; `None` where it is not UTF-8 or the
/// digits are missing.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        if first != b'%' {
            bytes.push(first);
            rest = after;
            continue;
        }
        let digits = after.get(..2).filter(|digits| digits.iter().all(u8::is_ascii_hexdigit))?;
        bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
        rest = &after[2..];
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(uri: &str, folder: &Path) -> String {
        read(uri, "buffers[0]", folder).unwrap_err().of(Path::new("a.gltf")).to_string()
    }

    #[test]
    fn names_that_leave_the_folder_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("shot");
        std::fs::create_dir_all(home.join("sub")).unwrap();
        std::fs::write(folder.path().join("secret"), "x").unwrap();
        std::fs::write(home.join("sub/a b.bin"), "bytes").unwrap();
        for uri in ["sub/a%20b.bin", "./sub/a b.bin"] {
            assert_eq!(read(uri, "buffers[0]", &home).unwrap(), b"bytes");
        }
        for (uri, why) in [
            ("../secret", "leaves its folder"),
            ("sub/../../secret", "leaves its folder"),
            ("%2e%2e/secret", "leaves its folder"),
            ("%2e%2e%2fsecret", "leaves its folder"),
            ("/etc/hostname", "leaves its folder"),
            ("file:///etc/hostname", "is an address"),
            ("https://example.com/a.bin", "is an address"),
            ("c:\\secret", "is an address"),
            ("..\\secret", "is an address"),
            ("a%", "is not a name"),
            ("a%zz", "is not a name"),
            ("a%+1", "is not a name"),
            ("%00", "is not a name"),
            ("", "is not a name"),
            ("none.bin", "is not there"),
            ("sub", "not a regular file"),
        ] {
            let error = refusal(uri, &home);
            assert!(error.contains(why) && error.contains("buffers[0] names"), "{uri}: {error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_that_leave_the_folder_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("shot");
        std::fs::create_dir(&home).unwrap();
        std::fs::write(folder.path().join("secret"), "x").unwrap();
        std::os::unix::fs::symlink(folder.path().join("secret"), home.join("a.bin")).unwrap();
        std::os::unix::fs::symlink(folder.path(), home.join("up")).unwrap();
        for uri in ["a.bin", "up/secret"] {
            assert!(refusal(uri, &home).contains("leaves its folder by a link"));
        }
    }

    #[test]
    fn data_in_the_name_is_decoded() {
        let nowhere = Path::new("nowhere");
        let data = "data:application/octet-stream;base64,AAEC/w==";
        assert_eq!(read(data, "buffers[0]", nowhere).unwrap(), [0, 1, 2, 255]);
        for bad in ["data:AAEC", "data:text/plain,abc", "data:;base64,A", "data:;base64,*"] {
            assert!(refusal(bad, nowhere).contains("not base64"), "{bad}");
        }
    }
}
