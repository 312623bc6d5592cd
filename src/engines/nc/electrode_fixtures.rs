//! A set of electrodes made by hand: one that holds, one overridden, one blocked.

use burning::duration::Spread;
use burning::figures::BurnFigures;
use glam::{DVec2, DVec3};

use files::{Figures, Override};
use geometry::mesh::Mesh;
use mold::electrode::base::Base;
use mold::electrode::cut::Cut;
use mold::electrode::design::Family;
use mold::electrode::design::{Burn, Electrode, ElectrodeSet, PartId, PartNode, RegionPlan};
use mold::electrode::finding::{CheckKind, Finding};
use mold::electrode::h_edge::EdgeChain;
use mold::electrode::params::{ElectrodeParams, Holder, Method, Orbit, Stage};
use mold::electrode::residual_stock::LeftOfRegion;

fn finding(kind: CheckKind, holds: bool, text: &str) -> Finding {
    let place = (!holds).then_some(DVec3::new(1.0, 2.0, -3.00004));
    let figures = if holds { Figures::new() } else { [("found_mm".to_owned(), 1.0)].into() };
    Finding { kind, holds, text: text.to_owned(), place, figures }
}

fn checks(failing: &[CheckKind]) -> Vec<Finding> {
    let text = |kind| match (kind, failing.contains(&kind)) {
        (CheckKind::Gouge, true) => "it comes to 0.0100 mm of the mold: too deep a burn",
        (_, true) => "it fails, \"badly\"",
        _ => "it holds",
    };
    CheckKind::ALL.map(|kind| finding(kind, !failing.contains(&kind), text(kind))).to_vec()
}

fn electrode(name: &str, stage: usize, burns: Vec<Burn>, size: DVec3) -> Electrode {
    Electrode {
        name: name.to_owned(),
        number: 0,
        stage,
        mesh: Mesh::cuboid(size).mapped(|p| p - DVec3::new(0.0, 0.0, 5.0)),
        tips: Mesh::cuboid(DVec3::ONE),
        burns,
        direction: DVec3::NEG_Z,
        method: Method::Extruding,
        blank: DVec3::new(10.0, 12.0, 25.0),
        holder: Some(0),
        figures: BurnFigures { minutes: Some(Spread::exactly(12.5)), ..BurnFigures::default() },
        needed: Some(1),
        is_thin: false,
        front_area: 4.0,
        burn_area: 11.0,
        base: Base { sides: DVec2::new(10.0, 12.0), is_round: false, height: 15.0, corner: 1.0 },
        family: Family::None,
        others: Mesh::default(),
        material: None,
        unmet: Vec::new(),
        other_way: None,
    }
}

fn burn(position: DVec3, turn_deg: f64, parts: &[(usize, usize)]) -> Burn {
    let parts = parts.iter().map(|&(region, part)| PartId { region, part }).collect();
    Burn {
        position,
        turn: turn_deg.to_radians(),
        parts,
        depth: 7.25,
        volume: 3.5,
        heads: None,
        minutes: Some(Spread::exactly(6.25)),
    }
}

fn leaf(part: usize) -> PartNode {
    PartNode {
        cut: None,
        h_edges: Vec::new(),
        heights: [-5.0, 0.0],
        outlines: Vec::new(),
        parts: Vec::new(),
        lacks_thin: false,
        part: Some(part),
        place: None,
    }
}

fn region(tree: Option<PartNode>, reason: Option<&str>, thickness: f64) -> RegionPlan {
    RegionPlan {
        is_set_aside: false,
        edits: Vec::new(),
        tree,
        earlier: Vec::new(),
        method: Method::Cutting,
        direction: DVec3::NEG_Z,
        reason: reason.map(str::to_owned),
        reason_place: None,
        left_out: Vec::new(),
        left: LeftOfRegion { thickness, place: DVec3::new(5.0, 6.0, 7.0), volume: 0.125, ..LeftOfRegion::default() },
        proposal: None,
    }
}

fn named(electrode: &str) -> Override {
    Override { of: electrode.to_owned(), ..Override::whatever("leftover") }
}

/// E01 burns part 1 of region 1 and, turned by 225 degrees, region 2; E02-finish is overridden; E03 burns part 2 of
/// region 1 and is blocked. Region 3 has no electrode.
pub fn set() -> ElectrodeSet {
    let rough = Stage {
        name: "rough".to_owned(),
        gap_mm: 0.2,
        stock_mm: 0.0,
        orbit: Orbit::Circular { radius_mm: 0.1 },
        finish_vdi: 30.0,
        last_step: String::new(),
        quantity: 2,
    };
    let two = vec![burn(DVec3::new(12.345_678, -4.5, 20.0), 90.0, &[(0, 0)]), burn(DVec3::NEG_X, 225.0, &[(1, 0)])];
    let mut overridden = electrode(
        "E02-finish",
        1,
        vec![burn(DVec3::new(-1e-9, 0.0, 3.0), 360.0, &[(1, 0), (0, 0)])],
        DVec3::splat(4.0),
    );
    (overridden.holder, overridden.direction) = (None, DVec3::X);
    let cut = Cut::upright(DVec2::new(1.5, -2.0), DVec2::Y, true);
    // Two edges of 2.5 and 0.5 mm.
    let chain = EdgeChain([-3.0, -0.5, 0.0].map(|z| DVec3::new(1.5, -2.0, z)).to_vec());
    let divided = PartNode { cut: Some(cut), h_edges: vec![chain], parts: vec![leaf(0), leaf(1)], ..leaf(0) };
    let divided = PartNode { part: None, ..divided };
    ElectrodeSet {
        params: ElectrodeParams {
            stages: vec![rough, Stage::finish(0.05)],
            material: "Cu, \"soft\"".to_owned(),
            overrides: ["E02-finish", "E99"].map(named).to_vec(),
            holders: vec![Holder { name: "holder 25".to_owned(), size_mm: [25.0; 2], height_mm: 20.0 }],
            ..ElectrodeParams::default()
        },
        electrodes: vec![
            electrode("E01", 0, two, DVec3::new(2.0, 3.0, 4.0)),
            overridden,
            electrode("E03", 1, vec![burn(DVec3::Y, -180.0, &[(0, 1)])], DVec3::ONE),
        ],
        checks: vec![
            checks(&[]),
            checks(&[CheckKind::ResidualStock]),
            // An open surface is not tried with the cutters.
            checks(&[CheckKind::Watertight, CheckKind::Gouge]).into_iter().take(4).collect(),
        ],
        regions: vec![
            region(Some(divided), None, 0.03),
            region(Some(leaf(0)), None, 0.0),
            region(None, Some("no room for a tip <of 0.3 mm>"), 0.9),
        ],
        names: Vec::new(),
    }
}
