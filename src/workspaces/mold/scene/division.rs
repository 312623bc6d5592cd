//! The division of regions drawn over the mold: H-edges of the heads, and where the heads are cut.

use glam::DVec3;

use mold::electrode::design::ElectrodeSet;
use mold::electrode::setting::to_burn_frame;
use mold::opening::Opening;
use render::colour::{Colour, Theme};
use render::scene::LineSet;

/// H-edges. On steel, on an electrode, on what is selected and on both backgrounds it is told apart.
const H_EDGE: Colour = Colour::rgb(0xe6, 0x00, 0x7e);
/// Widths of chains of H-edges: without an emphasised node, of the emphasised one, of the others (pixels).
const CHAINS: [f32; 3] = [3.0, 5.0, 1.5];
/// Widths of cuts, likewise.
const CUTS: [f32; 3] = [1.5, 3.0, 1.0];

/// Lines of one look (mm).
type Polylines = Vec<Vec<DVec3>>;

/// A node of the tree of divisions of a region.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodeAt {
    /// Index of the region.
    pub region: usize,
    /// Number of the node, each counted before its parts, as in [`mold::electrode::design::PartNode::nodes`].
    pub number: usize,
}

/// Chains of H-edges and cuts of these regions where they are burned, in the axes of the mesh; the emphasised node
/// stands out, and all others are faint beside it.
pub fn division_lines(
    (set, regions): (&ElectrodeSet, &[usize]),
    emphasised: Option<NodeAt>,
    opening: Opening,
    theme: Theme,
) -> Vec<LineSet> {
    let emphasised = emphasised.filter(|node| regions.contains(&node.region));
    // First those of the emphasised node, then those of all others.
    let (mut chains, mut cuts): ([Polylines; 2], [Polylines; 2]) = Default::default();
    for &region in regions {
        let Some(plan) = set.regions.get(region) else { continue };
        let back = to_burn_frame(plan.direction).transpose();
        let placed = |line: &Vec<DVec3>| line.iter().map(|p| opening.in_mesh(back * *p)).collect::<Vec<_>>();
        for (number, node) in plan.tree.iter().flat_map(|tree| tree.nodes()).enumerate() {
            let of = usize::from(emphasised != Some(NodeAt { region, number }));
            chains[of].extend(node.h_edges.iter().map(|chain| placed(&chain.0)));
            cuts[of].extend(node.cut_lines().iter().map(placed));
        }
    }
    let others = if emphasised.is_some() { 2 } else { 0 };
    let [of_edges, of_cuts] = if emphasised.is_some() { [theme.grid; 2] } else { [H_EDGE, theme.section] };
    let set_of = |lines, colour, width_px| LineSet { width_px, on_top: true, ..LineSet::new(lines, colour) };
    let ([own_chains, chains], [own_cuts, cuts]) = (chains, cuts);
    // What is drawn last lies over the others.
    let sets = [
        set_of(cuts, of_cuts, CUTS[others]),
        set_of(chains, of_edges, CHAINS[others]),
        set_of(own_cuts, theme.section, CUTS[1]),
        set_of(own_chains, H_EDGE, CHAINS[1]),
    ];
    sets.into_iter().filter(|set| !set.polylines.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nc::electrode_fixtures::set;

    #[test]
    fn the_node_that_is_emphasised_is_drawn_last_and_alone_in_colour() {
        let mut set = set();
        let tree = set.regions[0].tree.as_mut().unwrap();
        tree.outlines = vec![[(0.0, -4.0), (3.0, -4.0), (3.0, 0.0), (0.0, 0.0)].map(Into::into).to_vec()];
        tree.parts[0].h_edges = tree.h_edges.clone();
        let looks = |emphasised| -> Vec<(Colour, f32, usize)> {
            let lines = division_lines((&set, &[0, 1]), emphasised, Opening::PlusZ, Theme::DARK);
            lines.iter().map(|l| (l.colour, l.width_px, l.polylines.len())).collect()
        };
        let all = [(Theme::DARK.section, CUTS[0], 1), (H_EDGE, CHAINS[0], 2)];
        assert_eq!(looks(None), all);
        assert_eq!(looks(Some(NodeAt { region: 2, number: 0 })), all, "of a region that is not drawn");
        let faint = Theme::DARK.grid;
        assert_eq!(
            looks(Some(NodeAt { region: 0, number: 1 })),
            [(faint, CUTS[2], 1), (faint, CHAINS[2], 1), (H_EDGE, CHAINS[1], 1)]
        );
        assert_eq!(
            looks(Some(NodeAt { region: 0, number: 0 })),
            [(faint, CHAINS[2], 1), (Theme::DARK.section, CUTS[1], 1), (H_EDGE, CHAINS[1], 1)]
        );
    }

    #[test]
    fn chains_are_drawn_where_the_region_is_burned() {
        let mut set = set();
        set.regions[0].direction = DVec3::new(0.6, 0.0, -0.8);
        let opening = Opening::MinusY;
        let lines = division_lines((&set, &[0]), None, opening, Theme::LIGHT);
        let chain = &set.regions[0].tree.as_ref().unwrap().h_edges[0].0;
        let turned = to_burn_frame(set.regions[0].direction);
        for (drawn, own) in lines[0].polylines[0].iter().zip(chain) {
            assert!((turned * opening.upright(*drawn)).distance(*own) < 1e-9, "{drawn} {own}");
        }
    }
}
