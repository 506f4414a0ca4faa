//! The nodes of a scene and where each stands (glTF 2.0, section 3.5).

use super::document::{Document, MEND, Node, named};
use crate::error::Fault;
use snowgrain_math::{DAffine3, DMat3, DVec3};

/// A node in the world.
pub(super) struct Placed<'a> {
    pub(super) node: &'a Node,
    /// How messages call it.
    pub(super) name: String,
    /// Its own space to the world.
    pub(super) transform: DAffine3,
}

/// All nodes of the document's scene (the first where it chooses none), parents before children.
pub(super) fn nodes(document: &Document) -> Result<Vec<Placed<'_>>, Fault> {
    let index = document.scene.unwrap_or(0);
    if document.scenes.is_empty() {
        return Err(Fault::whole("it holds no scene", "export it with its scene"));
    }
    let scene = named(&document.scenes, "scenes", index, "the document")?;
    let mut reached = vec![false; document.nodes.len()];
    let mut placed = Vec::new();
    let owner = format!("scenes[{index}]");
    let root = |&node: &usize| (node, owner.clone(), DAffine3::IDENTITY);
    let mut waiting: Vec<_> = scene.nodes.iter().rev().map(root).collect();
    while let Some((index, owner, parent)) = waiting.pop() {
        let node = named(&document.nodes, "nodes", index, &owner)?;
        let name = format!("nodes[{index}]");
        if std::mem::replace(&mut reached[index], true) {
            let what = format!("{name} is reached twice: nodes must form a tree");
            return Err(Fault::whole(what, MEND));
        }
        let transform = parent * own_transform(node, &name)?;
        if !transform.is_finite() {
            return Err(Fault::whole(format!("{name} is moved beyond all numbers"), MEND));
        }
        waiting.extend(node.children.iter().rev().map(|&child| (child, name.clone(), transform)));
        placed.push(Placed { node, name, transform });
    }
    Ok(placed)
}

/// The node's space to that of its parent.
fn own_transform(node: &Node, name: &str) -> Result<DAffine3, Fault> {
    if let Some(m) = node.matrix {
        if [m[3], m[7], m[11]] != [0.0; 3] || m[15] != 1.0 {
            let what = format!("{name} has a matrix that is not affine");
            return Err(Fault::whole(what, MEND));
        }
        let column = |i: usize| DVec3::new(m[i], m[i + 1], m[i + 2]);
        let linear = DMat3::from_cols(column(0), column(4), column(8));
        return Ok(DAffine3::from_mat3_translation(linear, column(12)));
    }
    let scale = DMat3::from_diagonal(DVec3::from(node.scale.unwrap_or([1.0; 3])));
    let linear = match node.rotation {
        Some(quaternion) => rotation(quaternion, name)? * scale,
        None => scale,
    };
    let translation = DVec3::from(node.translation.unwrap_or_default());
    Ok(DAffine3::from_mat3_translation(linear, translation))
}

/// The rotation of a quaternion (x, y, z, w), which need not be of unit length.
fn rotation([x, y, z, w]: [f64; 4], name: &str) -> Result<DMat3, Fault> {
    let norm = x * x + y * y + z * z + w * w;
    if !(norm > 1e-12 && norm.is_finite()) {
        return Err(Fault::whole(format!("{name} has a rotation of no length"), MEND));
    }
    let s = 2.0 / norm;
    Ok(DMat3::from_cols(
        DVec3::new(1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)),
        DVec3::new(s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)),
        DVec3::new(s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)),
    ))
}
