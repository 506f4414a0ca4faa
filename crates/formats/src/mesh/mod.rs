//! Triangle meshes from OBJ, PLY and glTF files.
//!
//! Numbers in a file are lengths in the file's own unit; whoever loads it scales it to metres.

mod obj;
mod ply;

pub use ply::{PlyContent, ply_content};
pub(crate) use ply::{coordinates, single_property};

use crate::error::{Fault, FormatsError, Place};
use crate::{gltf, input};
use snowgrain_geometry::{GeometryError, TriangleMesh};
use std::path::Path;

/// Loads a mesh from an `.obj`, `.ply`, `.gltf` or `.glb` file; polygons become fans of triangles,
/// everything but positions, faces and texture coordinates is ignored, and all nodes of a glTF scene are one mesh.
///
/// # Errors
/// A missing or unreadable file; another extension; content that is not a mesh, with its line
/// or vertex.
pub fn load_mesh(path: &Path) -> Result<TriangleMesh, FormatsError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let mesh = match extension.as_deref() {
        Some("obj") => obj::parse(&input::read_whole(path)?),
        Some("gltf" | "glb") => gltf::joined_mesh(&input::read_whole(path)?, path),
        Some("ply") => {
            let (reader, length) = input::open(path)?;
            ply::read(reader, length)
        }
        _ => {
            input::open(path)?;
            let what = "this is not a mesh that Snowgrain reads";
            Err(Fault::whole(what, "give an .obj, .ply, .gltf or .glb file"))
        }
    };
    mesh.map_err(|fault| fault.of(path))
}

/// The checked mesh.
pub(crate) fn mesh(
    positions: Vec<snowgrain_math::DVec3>,
    triangles: Vec<[u32; 3]>,
    coordinates: Vec<[[f32; 2]; 3]>,
) -> Result<TriangleMesh, Fault> {
    TriangleMesh::with_coordinates(positions, triangles, coordinates).map_err(|error| {
        let place = match error {
            GeometryError::VertexNotFinite { vertex } => Place::Vertex(vertex as u64),
            _ => Place::Whole,
        };
        Fault::new(place, error.to_string(), "export the mesh again, with faces")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use snowgrain_math::DVec3;

    const SQUARE_OBJ: &str = "# a square\nmtllib none.mtl\no one\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\n\
        v 0 1 0.1\nvt 0 0\nusemtl red\nf 1/1 2/1 3/1 -1/1\n";

    fn obj(text: &str) -> Result<TriangleMesh, FormatsError> {
        obj::parse(text.as_bytes()).map_err(|fault| fault.of(Path::new("a.obj")))
    }

    fn ply(bytes: &[u8]) -> Result<TriangleMesh, FormatsError> {
        ply::read(bytes, bytes.len() as u64).map_err(|fault| fault.of(Path::new("a.ply")))
    }

    fn square() -> TriangleMesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.1]];
        TriangleMesh::new(corners.map(DVec3::from_array).to_vec(), vec![[0, 1, 2], [0, 2, 3]])
            .unwrap()
    }

    fn ply_header(format: &str) -> String {
        format!(
            "ply\r\nformat {format} 1.0\r\ncomment made by hand\nelement note 1\n\
             property uchar n\nelement vertex 4\nproperty double x\nproperty double y\n\
             property double z\nproperty list uchar short extra\nelement face 1\n\
             property list uchar uint vertex_indices\nproperty uchar colour\nend_header\n"
        )
    }

    fn ascii_ply() -> String {
        ply_header("ascii") + "7\n0 0 0 0\n1 0 0 2 8 9\n\n1 1 0 0\n0 1 0.1 0\n4 0 1 2 3 200\n"
    }

    fn binary_ply(big: bool) -> Vec<u8> {
        let name = if big { "binary_big_endian" } else { "binary_little_endian" };
        let mut bytes = ply_header(name).into_bytes();
        let mut put = |field: &[u8]| match big {
            true => bytes.extend(field.iter().rev()),
            false => bytes.extend(field),
        };
        put(&[7]);
        for position in &square().positions {
            position.to_array().iter().for_each(|x| put(&x.to_le_bytes()));
            put(&[1]);
            put(&(-3i16).to_le_bytes());
        }
        put(&[4]);
        (0u32..4).for_each(|corner| put(&corner.to_le_bytes()));
        put(&[200]);
        bytes
    }

    #[test]
    fn every_encoding_gives_the_same_square() {
        let placed = TriangleMesh { coordinates: vec![[[0.0; 2]; 3]; 2], ..square() };
        assert_eq!(obj(SQUARE_OBJ).unwrap(), placed);
        assert_eq!(ply(ascii_ply().as_bytes()).unwrap(), square());
        assert_eq!(ply(&binary_ply(false)).unwrap(), square());
        assert_eq!(ply(&binary_ply(true)).unwrap(), square());
    }

    #[test]
    fn objects_and_groups_are_joined() {
        let two = format!("{SQUARE_OBJ}g two\nv 5 5 5\nv 6 5 5\nv 5 6 5\nf -3 -2 -1\nf 1 2 7\n");
        let mesh = obj(&two).unwrap();
        assert_eq!(mesh.triangles.len(), 4);
        assert_eq!(mesh.corners(2)[1], DVec3::new(6.0, 5.0, 5.0));
        assert_eq!(mesh.corners(3)[1], DVec3::new(1.0, 0.0, 0.0));
    }

    #[test]
    fn corners_keep_their_places_in_a_picture() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 0.5 0\nvt 1 1\nvt 0 1\n\
            f 1/1 2/2 3/3\nf 1/1 1/1 1/1\nf 1/4 3/3 4/1\n";
        let mesh = obj(text).unwrap();
        let expected = [[[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]], [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]];
        assert_eq!(mesh.coordinates, expected, "those of the triangle without area are gone");
        let error = obj(&text.replace("vt 0.5 0", "vt nan 0")).unwrap_err().to_string();
        assert!(error.contains("texture coordinate"), "{error}");
        for [u, v] in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                 property float z\nproperty float {u}\nproperty float {v}\nelement face 1\n\
                 property list uchar int vertex_indices\nend_header\n0 0 0 0 1\n1 0 0 0.5 0\n\
                 0 1 0 1 1\n3 0 1 2\n"
            );
            let places = [[[0.0, 1.0], [0.5, 0.0], [1.0, 1.0]]];
            assert_eq!(ply(text.as_bytes()).unwrap().coordinates, places, "{u}");
        }
    }

    #[test]
    fn faults_of_obj_files_name_their_line() {
        let faults = [
            ("v 0 0 0\nv 1 nan 0\nf 1 1 1\n", "line 2: the coordinate \"nan\" is not a finite"),
            ("v 0 0 inf\n", "line 1: the coordinate \"inf\""),
            ("v 0 0 1e999\n", "line 1: the coordinate \"1e999\""),
            ("v 0 0\n", "line 1: a vertex needs three coordinates"),
            (
                "v 0 0 0\nf 1 2 3\nv 1 0 0\n",
                "line 2: the face names vertex 3, but there are only 2",
            ),
            ("v 0 0 0\nf 0 1 1\n", "line 2: the face names vertex 0"),
            ("v 0 0 0\nf -2 1 1\n", "line 2: the face names vertex -2"),
            ("v 0 0 0\nf 1 x 1\n", "line 2: \"x\" does not name a vertex"),
            ("v 0 0 0\nf\n", "line 2: the face has no corner"),
            ("solid cube\nfacet normal\n", "line 1: this is not an OBJ file: a line begins with"),
            ("", "the mesh has no vertex"),
            ("v 0 0 0\n", "the mesh has no face"),
            ("v 0 0 0\nf 1 1 1\n", "no triangle with an area"),
        ];
        for (text, message) in faults {
            let error = obj(text).unwrap_err();
            assert_eq!(error.exit_code(), 65);
            let error = error.to_string();
            assert!(error.starts_with("a.obj") && error.contains(message), "{text:?}: {error}");
        }
    }

    #[test]
    fn faults_of_ply_files_name_their_place() {
        let fine = ascii_ply();
        let faults = [
            ("1 1 0 0\n", "1 nan 0 0\n", "line 19: a coordinate is not a finite number"),
            ("1 1 0 0\n", "1 one 0 0\n", "line 19: \"one\" is not a number"),
            ("1 1 0 0\n", "1 1 0 1\n", "line 19: the row has too few numbers"),
            ("1 1 0 0\n", "1 1 0 0 0\n", "line 19: the row has more numbers"),
            ("0 1 2 3 200", "0 1 2 4 200", "line 21: the face names vertex 4"),
            ("0 1 2 3 200", "0 1 2 -1 200", "line 21: the face names vertex -1"),
            ("4 0 1 2 3 200", "2 0 1 200", "line 21: the face has 2 corners"),
            ("ply\r\n", "plyx\r\n", "line 1: this is not a PLY file"),
            ("property double x", "property quad x", "\"quad\" is not a type"),
            ("property double x", "property double w", "has no number \"x\""),
            ("vertex_indices", "corners", "no list of integers"),
            ("element vertex 4", "element vertex 4294967295", "claims 4294967295 rows"),
            ("end_header", "end", "\"end\" does not belong"),
            ("format ascii 1.0", "comment", "no \"format\" line"),
            ("4 0 1 2 3 200", "", "ends too early"),
        ];
        for (old, new, message) in faults {
            assert!(fine.contains(old), "{old}");
            let error = ply(fine.replacen(old, new, 1).as_bytes()).unwrap_err();
            assert_eq!(error.exit_code(), 65);
            let error = error.to_string();
            assert!(error.starts_with("a.ply") && error.contains(message), "{new:?}: {error}");
        }
        let mut binary = binary_ply(false);
        let end = binary.len();
        binary[end - 5] = 9; // the last corner
        let error = ply(&binary).unwrap_err().to_string();
        assert!(error.starts_with("a.ply, face 0 (from 0): the face names vertex"), "{error}");
    }

    #[test]
    fn files_are_told_apart_and_missing_ones_reported() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str, content: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            path
        };
        let mesh = at("MESH.PLY", &binary_ply(false));
        let grains = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n\
            property float y\nproperty float z\nproperty float radius\nend_header\n0 0 0 1\n";
        let grains = at("grains.ply", grains.as_bytes());
        assert_eq!(ply_content(&mesh).unwrap(), PlyContent::Mesh);
        assert_eq!(ply_content(&grains).unwrap(), PlyContent::Grains);
        assert_eq!(load_mesh(&mesh).unwrap(), square());
        assert!(load_mesh(&grains).unwrap_err().to_string().contains("holds grains"));
        let error = crate::read_grains(&mesh).unwrap_err().to_string();
        assert!(error.contains("has no number \"radius\""), "{error}");
        assert_eq!(crate::read_grains(&grains).unwrap().len(), 1);
        assert_eq!(load_mesh(&folder.path().join("none.obj")).unwrap_err().exit_code(), 66);
        assert_eq!(load_mesh(&at("a.stl", b"solid")).unwrap_err().exit_code(), 65);
        assert_eq!(load_mesh(folder.path()).unwrap_err().exit_code(), 65);
    }

    proptest! {
        #[test]
        fn damaged_files_are_read_or_refused(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            cut in any::<prop::sample::Index>(),
        ) {
            let files = [ascii_ply().into_bytes(), binary_ply(false), binary_ply(true)];
            for mut bytes in files.into_iter().chain([SQUARE_OBJ.as_bytes().to_vec()]) {
                for (at, value) in &changes {
                    let at = at.index(bytes.len());
                    bytes[at] = *value;
                }
                let cut = cut.index(bytes.len());
                let _ = (ply(&bytes), ply(&bytes[..cut]));
                let _ = (obj::parse(&bytes), obj::parse(&bytes[..cut]));
            }
        }

        #[test]
        fn any_text_is_read_or_refused(text in "([vfgol#] [-0-9a./ ]{0,20}\n|[a-z 0-9\n]{0,10}){0,12}") {
            let _ = obj(&text);
            let _ = ply(format!("ply\nformat ascii 1.0\n{text}").as_bytes());
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = obj::parse(&bytes);
            let _ = ply(&[&ply_header("binary_little_endian").into_bytes()[..], &bytes].concat());
        }
    }
}
