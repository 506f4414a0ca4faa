//! Every reader on every file that was made to do harm, and on mutations of them: no panic, and one line.

use crate::image::read_picture;
use crate::scene::SceneFile;
use crate::{
    FormatsError, film_summary, laboratory, load_environment, load_mesh, load_texture, read_film,
    read_gltf, read_grains,
};
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// The files.
static CORPUS: LazyLock<Vec<PathBuf>> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/hostile");
    let mut files: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
});

/// Name and content of short ones, of which a change may well touch what counts.
static SHORT: LazyLock<Vec<(PathBuf, Vec<u8>)>> = LazyLock::new(|| {
    let files = CORPUS.iter().map(|path| (path.clone(), std::fs::read(path).unwrap()));
    files.filter(|(_, bytes)| bytes.len() < 20_000).collect()
});

/// Gives a file to the readers of its kind.
fn survive(path: &Path) {
    let said = |result: Result<(), FormatsError>| {
        if let Err(error) = result {
            let line = error.to_string();
            assert!(!line.contains('\n') && line.len() < 1000, "{line}");
        }
    };
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("toml") => {
            let _ = SceneFile::read(path, &[]).and_then(|file| file.at_frame(1));
            said(
                laboratory::read_layers(
                    path,
                    &snowgrain_render::laboratory::Scatterers::Spheres,
                    0,
                )
                .map(drop),
            );
            said(laboratory::read_scatterers(&path.to_string_lossy(), 0).map(drop));
        }
        Some("obj") => said(load_mesh(path).map(drop)),
        Some("ply") => {
            said(load_mesh(path).map(drop));
            said(read_grains(path).map(drop));
        }
        Some("gltf" | "glb") => said(read_gltf(path).map(drop)),
        Some("exr" | "hdr" | "png") => {
            said(load_environment(path).map(drop));
            said(load_texture(path).map(drop));
            said(read_picture(path).map(drop));
        }
        Some("film") => {
            said(read_film(path).map(drop));
            said(film_summary(path).map(drop));
        }
        _ => {}
    }
}

#[test]
fn hostile_files_are_answered_by_every_reader() {
    CORPUS.iter().for_each(|path| survive(path));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn mutated_hostile_files_are_answered_by_every_reader(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        is_cut in any::<bool>(),
    ) {
        let (path, mut bytes) = which.get(&SHORT).clone();
        if !bytes.is_empty() {
            for (at, value) in changes {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            bytes.truncate(if is_cut { cut.index(bytes.len()) } else { bytes.len() });
        }
        let folder = tempfile::tempdir().unwrap();
        let mutated = folder.path().join(path.file_name().unwrap());
        std::fs::write(&mutated, bytes).unwrap();
        survive(&mutated);
    }
}
