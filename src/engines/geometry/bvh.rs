//! A hierarchy of oriented boxes over the triangles of a mesh, for distances between meshes.
//!
//! Oriented boxes, because the surfaces of an electrode and of its channel run parallel and close to each
//! other over long stretches: there a box as thin as its patch of surface tells near from far, one aligned
//! with the axes does not (S. Gottschalk, M. Lin, D. Manocha, OBBTree, SIGGRAPH 1996).
//!
//! Large meshes are first cut into blocks of some thousand triangles, by boxes along the axes. The hierarchy of a block
//! is built when it is first descended into: of a whole wheel an electrode comes near to few of them.

use std::cmp::Ordering;
use std::sync::OnceLock;

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};
use rayon::prelude::*;

use super::mesh::{Bounds, Mesh, normal_times_two_areas};
use super::triangle_distance::triangle_distance;
use task::{Cancel, Cancelled};

/// Most triangles of a [`Block`].
const BLOCK: usize = 2048;
/// Set in the numbers of nodes within blocks: below it the block's number, then the node's place in the block.
const IN_BLOCK: u32 = 1 << 31;
/// Bits of a node's place in its block, which has no more than `2 * BLOCK - 1` nodes.
const PLACE_BITS: u32 = 12;

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

/// A node of a [`Bvh`].
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
    /// The nodes down to the roots of the blocks; the root first.
    top: Vec<(Node, Below)>,
    blocks: Vec<Block>,
    /// Corners of the triangles by index in the mesh.
    corners: Vec<[DVec3; 3]>,
}

/// What stands below a node of the top.
#[derive(Debug, Clone, Copy)]
enum Below {
    Nodes([u32; 2]),
    Block(u32),
}

/// A subtree that is built when it is first asked for.
#[derive(Debug, Clone)]
struct Block {
    triangles: Vec<u32>,
    /// Each before its first subtree, that before its second; the root first.
    nodes: OnceLock<Vec<Node>>,
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
    /// Builds the hierarchy down to the blocks. An empty mesh gives a tree without nodes.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(mesh: &Mesh, cancel: &Cancel) -> Result<Self, Cancelled> {
        let corners: Vec<_> = (0..mesh.triangles.len()).into_par_iter().map(|i| mesh.corners(i)).collect();
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        arrange(&corners, &mut order, cancel)?;
        let mut tree = Self { top: Vec::new(), blocks: Vec::new(), corners };
        if !order.is_empty() {
            let mut blocks = Vec::new();
            halve(&order, &mut |block| blocks.push(block));
            let fitted = |block: &&[u32]| {
                cancel.check()?;
                Ok((fitted(&tree.corners, block), Bounds::of(block.iter().flat_map(|&t| tree.corners[t as usize]))))
            };
            let roots: Vec<(Node, Bounds)> = blocks.par_iter().map(fitted).collect::<Result<_, _>>()?;
            tree.grow(&order, &mut roots.into_iter());
        }
        Ok(tree)
    }

    /// Adds the nodes over the triangles in `order`, whose blocks have the next of `roots` with the boxes along the axes
    /// around them; answers the number of their root and the box around it.
    fn grow(&mut self, order: &[u32], roots: &mut impl Iterator<Item = (Node, Bounds)>) -> Option<(u32, Bounds)> {
        let number = self.top.len() as u32;
        if order.len() <= BLOCK {
            let (root, bounds) = roots.next()?;
            self.top.push((root, Below::Block(self.blocks.len() as u32)));
            self.blocks.push(Block { triangles: order.to_vec(), nodes: OnceLock::new() });
            return Some((number, bounds));
        }
        let (count, triangle) = (order.len() as u32, order[0]);
        let bounds = OrientedBox { center: DVec3::ZERO, axes: DMat3::IDENTITY, half: DVec3::ZERO };
        self.top.push((Node { bounds, radius: 0.0, count, triangle }, Below::Nodes([0; 2])));
        let (low, high) = order.split_at(order.len() / 2);
        let ((first, a), (second, b)) = (self.grow(low, roots)?, self.grow(high, roots)?);
        let around = Bounds { min: a.min.min(b.min), max: a.max.max(b.max) };
        let (node, below) = &mut self.top[number as usize];
        node.bounds = OrientedBox { center: around.center(), half: around.size() * 0.5, ..bounds };
        node.radius = node.bounds.half.length();
        *below = Below::Nodes([first, second]);
        Some((number, around))
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.top.is_empty()
    }

    /// The node of this number; that of the root is 0.
    pub fn node(&self, number: u32) -> &Node {
        if number & IN_BLOCK == 0 {
            return &self.top[number as usize].0;
        }
        let place = number & ((1 << PLACE_BITS) - 1);
        &self.nodes_of((number & !IN_BLOCK) >> PLACE_BITS)[place as usize]
    }

    /// The two halves of a node, unless it is a leaf.
    pub fn children(&self, number: u32) -> Option<[u32; 2]> {
        if self.node(number).count == 1 {
            return None;
        }
        let first = match self.top.get(number as usize) {
            Some((_, Below::Nodes(halves))) => return Some(*halves),
            Some((_, Below::Block(block))) => (IN_BLOCK | block << PLACE_BITS) + 1,
            None => number + 1,
        };
        // A binary tree with one triangle to a leaf has 2 n - 1 nodes, which places the second child.
        Some([first, first + 2 * self.node(first).count - 1])
    }

    fn nodes_of(&self, block: u32) -> &[Node] {
        let Block { triangles, nodes } = &self.blocks[block as usize];
        nodes.get_or_init(|| {
            let mut nodes = Vec::with_capacity(2 * triangles.len() - 1);
            subtree(&self.corners, &mut triangles.clone(), &mut nodes);
            nodes
        })
    }

    /// Whether the surfaces come within `reach` (mm) of each other.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn meets(&self, other: &Self, reach: f64, cancel: &Cancel) -> Result<bool, Cancelled> {
        if self.is_empty() || other.is_empty() {
            return Ok(false);
        }
        let mut pairs = vec![(0, 0)];
        let mut looked_at = 0_u32;
        while let Some((a, b)) = pairs.pop() {
            looked_at = looked_at.wrapping_add(1);
            if looked_at.is_multiple_of(4096) {
                cancel.check()?;
            }
            let (own, others) = (self.node(a), other.node(b));
            if own.bounds.separation(&others.bounds).length() > reach {
                continue;
            }
            match (self.children(a), other.children(b)) {
                (None, None) => {
                    let (first, second) = (self.corners(own.triangle), other.corners(others.triangle));
                    if triangle_distance(first, second).distance <= reach {
                        return Ok(true);
                    }
                }
                (_, Some(halves)) if others.count > own.count => pairs.extend(halves.map(|half| (a, half))),
                (Some(halves), _) => pairs.extend(halves.map(|half| (half, b))),
                (None, Some(halves)) => pairs.extend(halves.map(|half| (a, half))),
            }
        }
        Ok(false)
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

/// Puts triangles that are near each other into the same block: halves `order` across the longest side of the box that
/// they lie in until the halves are blocks.
fn arrange(corners: &[[DVec3; 3]], order: &mut [u32], cancel: &Cancel) -> Result<(), Cancelled> {
    cancel.check()?;
    if order.len() <= BLOCK {
        return Ok(());
    }
    let place = |t: u32| corners[t as usize].iter().sum::<DVec3>();
    let size = Bounds::of(order.iter().map(|&t| place(t))).size();
    let across = (1..3).fold(0, |longest, k| if size[k] > size[longest] { k } else { longest });
    let (low, high) = split(order, |t| place(t)[across]);
    let (low, high) = rayon::join(|| arrange(corners, low, cancel), || arrange(corners, high, cancel));
    low.and(high)
}

/// Shows `see` the blocks of `order` one after the other.
fn halve<'a>(order: &'a [u32], see: &mut impl FnMut(&'a [u32])) {
    if order.len() <= BLOCK {
        return see(order);
    }
    let (low, high) = order.split_at(order.len() / 2);
    halve(low, see);
    halve(high, see);
}

/// Adds the nodes of a tree over the triangles in `order`, which it sorts as it goes.
fn subtree(corners: &[[DVec3; 3]], order: &mut [u32], nodes: &mut Vec<Node>) {
    let node = fitted(corners, order);
    nodes.push(node);
    if order.len() > 1 {
        let (low, high) = split(order, |t| node.bounds.axes.x_axis.dot(corners[t as usize].iter().sum::<DVec3>()));
        subtree(corners, low, nodes);
        subtree(corners, high, nodes);
    }
}

/// The halves of `order` by `key`. Ties are broken by index, so that they do not depend on how the selection shuffles.
fn split(order: &mut [u32], key: impl Fn(u32) -> f64) -> (&mut [u32], &mut [u32]) {
    let middle = order.len() / 2;
    let by_key = |a: &u32, b: &u32| key(*a).partial_cmp(&key(*b)).unwrap_or(Ordering::Equal).then(a.cmp(b));
    order.select_nth_unstable_by(middle, by_key);
    order.split_at_mut(middle)
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

    #[test]
    fn surfaces_meet_where_their_triangles_come_near() {
        let cube = |from: f64, size: f64| Mesh::cuboid(DVec3::splat(size)).mapped(|p| p + from);
        let tree = |mesh: &Mesh| Bvh::new(mesh, &Cancel::default()).unwrap();
        let outer = tree(&cube(0.0, 10.0));
        for (other, reach, meet) in [
            (cube(4.0, 1.0), 0.0, false),
            (cube(9.5, 1.0), 0.0, true),
            (cube(9.0, 1.0), 0.0, true),
            (cube(9.0 - 1e-3, 1.0), 0.0, false),
            (cube(9.0 - 1e-3, 1.0), 2e-3, true),
            (cube(11.0, 1.0), 1.7, false),
            (cube(11.0, 1.0), 1.8, true),
        ] {
            let other = tree(&other);
            assert_eq!(outer.meets(&other, reach, &Cancel::default()).unwrap(), meet);
            assert_eq!(other.meets(&outer, reach, &Cancel::default()).unwrap(), meet);
        }
        assert!(!outer.meets(&tree(&Mesh::default()), 1.0, &Cancel::default()).unwrap());
    }

    proptest! {
        #[test]
        fn every_node_holds_its_triangles_and_every_triangle_is_once_below_the_root(list in triangles()) {
            let tree = tree_of(&list);
            let mut all = below(&tree, 0);
            all.sort_unstable();
            prop_assert_eq!(all, (0..list.len() as u32).collect::<Vec<_>>());
            let mut numbers = vec![0];
            while let Some(number) = numbers.pop() {
                let node = tree.node(number);
                numbers.extend(tree.children(number).into_iter().flatten());
                for p in below(&tree, number).into_iter().flat_map(|t| *tree.corners(t)) {
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
    fn a_tree_of_many_blocks_holds_every_triangle_once_and_its_boxes_hold_theirs() {
        let list: Vec<_> = (0..3 * BLOCK as u32)
            .map(|i| {
                let p = DVec3::new(f64::from(i * 7 % 101), f64::from(i * 13 % 89), f64::from(i * 29 % 97));
                [p, p + DVec3::X, p + DVec3::Y * 0.5]
            })
            .collect();
        let tree = tree_of(&list);
        assert_eq!(tree.blocks.len(), 4);
        let mut all = below(&tree, 0);
        all.sort_unstable();
        assert_eq!(all, (0..list.len() as u32).collect::<Vec<_>>());
        let (mut numbers, mut nodes) = (vec![0], 0);
        while let Some(number) = numbers.pop() {
            nodes += 1;
            let node = tree.node(number);
            let children = tree.children(number);
            assert_eq!(children.is_none(), node.count == 1);
            assert!(children.is_none_or(|c| c.iter().map(|&c| tree.node(c).count).sum::<u32>() == node.count));
            numbers.extend(children.into_iter().flatten());
            for p in below(&tree, number).into_iter().flat_map(|t| *tree.corners(t)) {
                let local = node.bounds.axes.transpose() * (p - node.bounds.center);
                assert!((local.abs() - node.bounds.half).max_element() < 1e-9);
                assert!(p.distance(node.bounds.center) < node.radius + 1e-9);
            }
        }
        assert_eq!(nodes, 2 * list.len() - 1);
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
