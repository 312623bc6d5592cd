//! A hierarchy of oriented boxes over the triangles of a mesh, for distances between meshes.
//!
//! Oriented boxes, because the surfaces of an electrode and of its channel run parallel and close to each
//! other over long stretches: there a box as thin as its patch of surface tells near from far, one aligned
//! with the axes does not (S. Gottschalk, M. Lin, D. Manocha, OBBTree, SIGGRAPH 1996).

use std::cmp::Ordering;

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};

use super::mesh::{Mesh, normal_times_two_areas};
use task::{Cancel, Cancelled};

/// Below this many triangles a subtree is built on the thread at hand.
const PARALLEL_FROM: usize = 2048;

/// A box of any attitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// Middle point.
    pub center: DVec3,
    /// Unit vectors along its edges, as columns.
    pub axes: DMat3,
    /// Half the edge lengths.
    pub half: DVec3,
}

/// A node of a [`Bvh`]. Its subtree follows it in the list of nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Holds the triangles of the subtree.
    pub bounds: OrientedBox,
    /// No point of the subtree's triangles is further than this from the middle of `bounds` (mm).
    pub radius: f64,
    /// Triangles of the subtree (in a leaf: 1).
    pub count: u32,
    /// The triangle of a leaf, as an index into the mesh; the first of the subtree otherwise.
    pub triangle: u32,
}

/// A binary tree over the triangles of a mesh, one triangle to a leaf. The same mesh gives the same tree on
/// any number of threads.
#[derive(Debug, Clone)]
pub struct Bvh {
    /// The nodes, each before its first subtree, that before its second; the root first.
    nodes: Vec<Node>,
    /// Corners of the triangles by index in the mesh.
    corners: Vec<[DVec3; 3]>,
}

impl OrientedBox {
    /// The smallest box with these axes around `points`.
    fn around(axes: DMat3, points: impl Iterator<Item = DVec3>) -> Self {
        let across = axes.transpose();
        let (min, max) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| {
            let q = across * p;
            (min.min(q), max.max(q))
        });
        Self { center: axes * ((min + max) * 0.5), axes, half: (max - min) * 0.5 }
    }

    /// This box moved by `p -> rotation * p + shift`.
    pub fn placed(&self, rotation: &DMat3, shift: DVec3) -> Self {
        Self { center: *rotation * self.center + shift, axes: *rotation * self.axes, half: self.half }
    }

    /// The least of `direction . p` over the points of the box.
    pub fn least_along(&self, direction: DVec3) -> f64 {
        let axes = &self.axes;
        let along = DVec3::new(axes.x_axis.dot(direction), axes.y_axis.dot(direction), axes.z_axis.dot(direction));
        direction.dot(self.center) - along.abs().dot(self.half)
    }

    /// A vector along which the two boxes, and so all they hold, are apart by at least its length; it points
    /// from `other` to `self`. Zero if no face of either box separates them.
    pub fn separation(&self, other: &Self) -> DVec3 {
        let between = self.center - other.center;
        let (own_axes, other_axes) = (self.axes.transpose(), other.axes.transpose());
        let turned = other_axes * self.axes;
        let turned_size = turned.abs();
        // In the frame of each box the other fits into a box along the axes; the vector between these two is
        // a separation, and the better of the two frames is taken.
        let in_other = gap(other_axes * between, other.half + turned_size * self.half);
        let in_own = gap(own_axes * between, self.half + turned_size.transpose() * other.half);
        if in_other.length_squared() >= in_own.length_squared() { other.axes * in_other } else { self.axes * in_own }
    }
}

/// Gap that remains of `between`, axis by axis, after taking off `extent` on either side.
fn gap(between: DVec3, extent: DVec3) -> DVec3 {
    (between.abs() - extent).max(DVec3::ZERO) * between.signum()
}

impl Bvh {
    /// Builds the hierarchy. An empty mesh gives a tree without nodes.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(mesh: &Mesh, cancel: &Cancel) -> Result<Self, Cancelled> {
        let corners: Vec<_> = mesh.iter_corners().collect();
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        let nodes = if order.is_empty() { Vec::new() } else { subtree(&corners, &mut order, cancel)? };
        Ok(Self { nodes, corners })
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The node at `index`; the root is 0.
    pub fn node(&self, index: u32) -> &Node {
        &self.nodes[index as usize]
    }

    /// The two halves of node `index`, unless it is a leaf.
    pub fn children(&self, index: u32) -> Option<[u32; 2]> {
        let node = self.node(index);
        // A binary tree with one triangle to a leaf has 2 n - 1 nodes, which places the second child.
        (node.count > 1).then(|| [index + 1, index + 2 * self.node(index + 1).count])
    }

    /// Corners of every triangle in the order of the mesh.
    pub fn triangles(&self) -> &[[DVec3; 3]] {
        &self.corners
    }

    /// Corners of a triangle, by its index in the mesh.
    pub fn corners(&self, triangle: u32) -> &[DVec3; 3] {
        &self.corners[triangle as usize]
    }
}

/// The nodes of a tree over the triangles in `order`, which it sorts as it goes.
fn subtree(corners: &[[DVec3; 3]], order: &mut [u32], cancel: &Cancel) -> Result<Vec<Node>, Cancelled> {
    cancel.check()?;
    let node = fitted(corners, order);
    if order.len() == 1 {
        return Ok(vec![node]);
    }
    let key = |t: u32| node.bounds.axes.x_axis.dot(corners[t as usize].iter().sum::<DVec3>());
    let middle = order.len() / 2;
    // Ties are broken by index, so that the tree does not depend on how the selection shuffles.
    let by_key = |a: &u32, b: &u32| key(*a).partial_cmp(&key(*b)).unwrap_or(Ordering::Equal).then(a.cmp(b));
    order.select_nth_unstable_by(middle, by_key);
    let (low, high) = order.split_at_mut(middle);
    let (first, second) = if low.len() >= PARALLEL_FROM {
        rayon::join(|| subtree(corners, low, cancel), || subtree(corners, high, cancel))
    } else {
        (subtree(corners, low, cancel), subtree(corners, high, cancel))
    };
    let (first, second) = (first?, second?);
    let mut nodes = Vec::with_capacity(1 + first.len() + second.len());
    nodes.push(node);
    nodes.extend(first);
    nodes.extend(second);
    Ok(nodes)
}

/// The node around the triangles in `order`: the first axis of its box is the longest, the last the thinnest.
fn fitted(corners: &[[DVec3; 3]], order: &[u32]) -> Node {
    let axes = principal_axes(corners, order);
    let points = || order.iter().flat_map(|&t| corners[t as usize]);
    let bounds = OrientedBox::around(axes, points());
    let radius = points().map(|p| p.distance_squared(bounds.center)).fold(0.0, f64::max).sqrt();
    Node { bounds, radius, count: order.len() as u32, triangle: order[0] }
}

/// The axes along which the triangles' area is spread most, middling and least.
fn principal_axes(corners: &[[DVec3; 3]], order: &[u32]) -> DMat3 {
    let origin = corners[order[0] as usize][0];
    let (mut area, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for &t in order {
        let [a, b, c] = corners[t as usize].map(|p| p - origin);
        // A trace of weight keeps triangles without area in the count.
        let weight = normal_times_two_areas([a, b, c]).length() + 1e-12;
        let sum = a + b + c;
        area += weight;
        first += sum * (weight / 3.0);
        second += (outer(sum) + outer(a) + outer(b) + outer(c)) * (weight / 12.0);
    }
    let mean = first / area;
    let spread = second * (1.0 / area) + outer(mean) * -1.0;
    let matrix = Matrix3::from_column_slice(&spread.to_cols_array());
    let Some(eigen) = SymmetricEigen::try_new(matrix, f64::EPSILON, 100) else { return DMat3::IDENTITY };
    let mut by_value = [0, 1, 2];
    by_value.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let column = |i: usize| DVec3::from_array(std::array::from_fn(|row| eigen.eigenvectors[(row, by_value[i])]));
    let (x, y) = (column(0), column(1));
    match (x.try_normalize(), (y - x * x.dot(y)).try_normalize()) {
        (Some(x), Some(y)) => DMat3::from_cols(x, y, x.cross(y)),
        _ => DMat3::IDENTITY,
    }
}

/// The matrix `v v^T`.
fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn mesh_of(triangles: &[[DVec3; 3]]) -> Mesh {
        let vertices = triangles.iter().flatten().copied().collect();
        Mesh { vertices, triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect() }
    }

    fn tree_of(triangles: &[[DVec3; 3]]) -> Bvh {
        Bvh::new(&mesh_of(triangles), &Cancel::default()).unwrap()
    }

    fn triangles() -> impl Strategy<Value = Vec<[DVec3; 3]>> {
        let point = || (-9.0..9.0, -9.0..9.0, -9.0..9.0).prop_map(|(x, y, z)| DVec3::new(x, y, z));
        prop::collection::vec([point(), point(), point()], 1..40)
    }

    /// The triangles below a node, found by walking down.
    fn below(tree: &Bvh, node: u32) -> Vec<u32> {
        match tree.children(node) {
            Some(children) => children.into_iter().flat_map(|c| below(tree, c)).collect(),
            None => vec![tree.node(node).triangle],
        }
    }

    proptest! {
        #[test]
        fn every_node_holds_its_triangles_and_every_triangle_is_once_below_the_root(list in triangles()) {
            let tree = tree_of(&list);
            let mut all = below(&tree, 0);
            all.sort_unstable();
            prop_assert_eq!(all, (0..list.len() as u32).collect::<Vec<_>>());
            for index in 0..2 * list.len() as u32 - 1 {
                let node = tree.node(index);
                for p in below(&tree, index).into_iter().flat_map(|t| *tree.corners(t)) {
                    let local = node.bounds.axes.transpose() * (p - node.bounds.center);
                    prop_assert!((local.abs() - node.bounds.half).max_element() < 1e-9);
                    prop_assert!(p.distance(node.bounds.center) < node.radius + 1e-9);
                }
            }
        }

        #[test]
        fn a_separation_separates_whatever_the_boxes_hold(a in triangles(), b in triangles(), far in -30.0..30.0) {
            let (first, second) = (tree_of(&a), tree_of(&b));
            let shift = DVec3::new(far, 0.3 * far, -0.1 * far);
            let turn = DMat3::from_rotation_y(far) * DMat3::from_rotation_x(0.7);
            let vector = first.node(0).bounds.placed(&turn, shift).separation(&second.node(0).bounds);
            if vector.length() > 0.0 {
                let n = vector.normalize();
                let least = a.iter().flatten().map(|&p| n.dot(turn * p + shift)).fold(f64::INFINITY, f64::min);
                let most = b.iter().flatten().map(|&p| n.dot(p)).fold(f64::NEG_INFINITY, f64::max);
                prop_assert!(least - most >= vector.length() - 1e-9);
            }
        }
    }

    #[test]
    fn a_flat_patch_gets_a_flat_box() {
        let turn = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(1.1);
        let list: Vec<_> = (0..20)
            .map(|i| [[0.0, 0.0], [1.0, 0.2], [0.1, 0.5]].map(|[x, y]| turn * DVec3::new(x + i as f64, y, 0.0)))
            .collect();
        let root = *tree_of(&list).node(0);
        assert!(root.bounds.half.z < 1e-9 && root.bounds.half.x > 9.9 && root.bounds.half.y < 0.4, "{root:?}");
    }

    #[test]
    fn boxes_side_by_side_are_as_far_apart_as_their_faces() {
        let unit = OrientedBox { center: DVec3::ZERO, axes: DMat3::IDENTITY, half: DVec3::ONE };
        let moved = unit.placed(&DMat3::from_rotation_x(0.3), DVec3::new(5.0, 0.2, 0.1));
        assert!((moved.separation(&unit) - DVec3::X * 3.0).length() < 1e-12);
        let apart = unit.placed(&DMat3::IDENTITY, DVec3::new(-5.0, 6.0, 0.0));
        assert!((apart.separation(&unit) - DVec3::new(-3.0, 4.0, 0.0)).length() < 1e-12);
        assert_eq!(unit.separation(&unit), DVec3::ZERO);
    }
}
