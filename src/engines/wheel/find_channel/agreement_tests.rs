//! What was found is measured against the mesh, and channels are told from each other.

use std::collections::HashMap;

use glam::{DQuat, DVec2, DVec3};

use super::tests::{coarse, find, found, refused};
use super::*;
use crate::channel::{Difference, Surface, Unlike};
use crate::fixtures::{TestBlisk, together, turned_part};
use crate::options::{Auto, AxisChoice, AxisLine, AxisName, EndWalls};
use crate::parametric::wheel::{Flaws, ParametricWheel, Splitters};
use geometry::frame::{Cylindrical, wrap_angle};
use geometry::mesh::{Mesh, normal_times_two_areas};

#[test]
fn a_slightly_bent_blade_neither_moves_the_axis_nor_goes_unsaid() {
    let part = TestBlisk::default();
    let straight = part.mesh();
    let bent = straight.mapped(|p| {
        let c = geometry::frame::Cylindrical::from_point(p);
        let on_blade_6 = c.r > 51.0 && c.r < 61.0 && (c.theta - 6.0 * part.pitch()).abs() < 0.55 * part.pitch();
        geometry::frame::Cylindrical { theta: c.theta + if on_blade_6 { 0.01 } else { 0.0 }, ..c }.point()
    });
    let channel = found(&bent);
    assert_eq!(channel.blades, 24);
    assert!(channel.frame.origin.length() < 0.02, "{}", channel.frame.origin);
    assert_eq!(channel.unlike.len(), 2, "the channels on both its sides: {:?}", channel.assumed);
}

#[test]
fn what_was_found_is_measured_against_the_mesh_and_refused_where_that_is_otherwise() {
    let mesh = TestBlisk { grid: [48, 8, 8, 2], ..Default::default() }.mesh();
    for options in [BliskOptions::default(), BliskOptions { hub_radius_mm: Auto::Given(51.0), ..Default::default() }] {
        let channel = find(&mesh, &options).unwrap();
        assert_eq!(channel.agreement.len(), 4);
        assert!(channel.agreement.iter().all(|a| a.samples > 100 && a.share >= 0.95), "{:?}", channel.agreement);
    }
    // End walls that wave around the axis are no hub and no shroud.
    for (name, surface, [from, to]) in [("hub", Surface::Hub, [49.0, 50.5]), ("shroud", Surface::Shroud, [61.5, 62.5])]
    {
        let waved = mesh.mapped(|p| {
            let Cylindrical { x, r, theta } = Cylindrical::from_point(p);
            let wave = if (from..to).contains(&r) { 0.3 * (24.0 * theta).sin() } else { 0.0 };
            Cylindrical { x, r: r + wave, theta }.point()
        });
        let refusal = find(&waved, &BliskOptions::default()).unwrap_err();
        assert!(refusal.to_string().contains(&format!("the {name} that was found is up to")));
        let BliskError::Disagrees(found) = refusal else {
            panic!("a waved {name} is taken for one");
        };
        assert_eq!(found.surface, surface);
        assert!(found.share < 0.95 && found.greatest_mm > 0.1 && found.greatest_mm < 0.7, "{found:?}");
    }
}

#[test]
fn channels_that_are_not_like_the_found_one_are_named() {
    let part = TestBlisk::default();
    assert!(found(&part.mesh()).unlike.is_empty());
    // A lump on the hub of channel 3 and, in the same way, on the shroud of channel 7.
    let lumps = [(3.0, 50.0), (7.0, 62.0)].map(|(channel, radius)| {
        let theta = part.pitch() * channel + 0.5 * part.wall(7.0, 56.0).iter().sum::<f64>();
        let at = Cylindrical { x: 7.0, r: radius, theta }.point();
        Mesh::cuboid(DVec3::splat(6.0)).mapped(|p| p - DVec3::splat(3.0) + at)
    });
    let mesh = lumps.iter().fold(part.mesh(), together);
    let channel = found(&mesh);
    assert_eq!(channel.unlike.len(), 2, "{:?}", channel.unlike);
    assert!(channel.assumed.iter().any(|a| a.contains("Of the other 23 channels of its kind, 2 are not like")));
    // One blade out of 24 turned by 0.4 mm spoils the channels on both its sides.
    let turned = ParametricWheel {
        flaws: Flaws { turned_blade: Some((5, 0.4 / 80.0)), ..Default::default() },
        ..coarse(ParametricWheel::nozzle_ring())
    }
    .mesh();
    let channel = found(&turned);
    let mut walls: Vec<_> = channel.unlike.iter().map(|unlike| unlike.difference).collect();
    walls.sort_by_key(|difference| matches!(difference, Difference::Surface { surface: Surface::HighWall, .. }));
    let [Difference::Surface { surface: Surface::LowWall, greatest_mm: low }, other] = walls[..] else {
        panic!("{walls:?}");
    };
    let Difference::Surface { surface: Surface::HighWall, greatest_mm: high } = other else { panic!("{other:?}") };
    // The turn moves places by 0.005 rad of their radius, 68 to 104 mm, along the circle, and less along the normal.
    for off in [low, high] {
        assert!((0.2..0.52).contains(&off), "{walls:?}");
    }
}

/// The mesh with the other diagonal in some pairs of its triangles, those that `is_other` of a corner and the normal.
fn other_diagonals(mesh: &Mesh, is_other: impl Fn(DVec3, DVec3) -> bool) -> Mesh {
    let sides: HashMap<(u32, u32), usize> = mesh.sides().collect();
    let mut other = mesh.clone();
    let mut is_turned = vec![false; mesh.triangles.len()];
    let normal = |t: [u32; 3]| normal_times_two_areas(t.map(|v| mesh.vertices[v as usize]));
    for (i, t) in mesh.triangles.iter().enumerate() {
        for [a, b, c] in [[t[0], t[1], t[2]], [t[1], t[2], t[0]], [t[2], t[0], t[1]]] {
            let Some(&k) = sides.get(&(b, a)) else { continue };
            let Some(d) = mesh.triangles[k].into_iter().find(|v| *v != a && *v != b) else { continue };
            let [old, beside] = [normal(*t), normal(mesh.triangles[k])];
            let turned = [[a, d, c], [d, b, c]];
            let is_bent = (0.01..0.4).contains(&old.angle_between(beside));
            let is_sound = turned
                .iter()
                .all(|t| normal(*t).dot(old + beside) > 0.5 * normal(*t).length() * (old + beside).length());
            let is_new = !sides.contains_key(&(c, d)) && !sides.contains_key(&(d, c));
            if is_bent
                && is_sound
                && is_new
                && !is_turned[i]
                && !is_turned[k]
                && is_other(mesh.vertices[a as usize], old)
            {
                (is_turned[i], is_turned[k]) = (true, true);
                [other.triangles[i], other.triangles[k]] = turned;
            }
        }
    }
    other
}

/// Facets of other channels may stand for the same surface in another way.
#[test]
fn coarse_facets_make_no_channels_differ() {
    let part = ParametricWheel { pieces: [160, 16, 3], ..ParametricWheel::impeller() };
    let is_blade = |p: DVec3, normal: DVec3| normal.normalize().dot(DVec3::X.cross(p).normalize()).abs() > 0.5;
    let mesh = other_diagonals(&part.mesh(), |p, normal| Cylindrical::from_point(p).theta > 0.7 && is_blade(p, normal));
    let channel = found(&mesh);
    assert!(channel.unlike.is_empty(), "{:?}", channel.unlike);
}

/// The mesh whose triangles were divided into four so many times.
pub(super) fn quartered(mesh: &Mesh, times: usize) -> Mesh {
    (0..times).fold(mesh.clone(), |Mesh { mut vertices, triangles }, _| {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let [p, q] = [a, b].map(|v| vertices[v as usize]);
                // Rounded as in an STL file.
                vertices.push((0.5 * (p + q)).as_vec3().as_dvec3());
                vertices.len() as u32 - 1
            })
        };
        let quarters = |[a, b, c]: [u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        let triangles = triangles.into_iter().flat_map(quarters).collect();
        Mesh { vertices, triangles }
    })
}

/// Facets that were divided say no more of the surface that they stand for than they did whole, those of hub and shroud
/// that stand for it in another way in other channels included.
#[test]
fn divided_facets_are_as_coarse_as_whole_ones() {
    let part = ParametricWheel { pieces: [108, 12, 2], ..ParametricWheel::impeller() };
    let is_end_wall = |p: DVec3, normal: DVec3| normal.normalize().dot(DVec3::X.cross(p).normalize()).abs() < 0.3;
    let is_other = |p: DVec3, normal| Cylindrical::from_point(p).theta > 0.7 && is_end_wall(p, normal);
    let mesh = other_diagonals(&part.mesh(), is_other);
    let whole = found(&mesh);
    let divided = found(&quartered(&mesh, 2));
    assert_eq!((divided.blades, divided.unlike.len()), (whole.blades, 0));
    assert!((divided.throat.width_mm - whole.throat.width_mm).abs() < 0.05 * whole.throat.width_mm);
}

/// Facets of a large part may be further off the surfaces that they stand for than a small one's are large.
#[test]
fn a_part_is_found_at_any_size() {
    let part = ParametricWheel { pieces: [120, 16, 3], ..ParametricWheel::impeller() };
    let width = |scale: f64| found(&part.mesh().mapped(|p| scale * p)).throat.width_mm / scale;
    let widths = [0.1, 1.0, 30.0].map(width);
    assert!(widths.iter().all(|w| (w / widths[1] - 1.0).abs() < 1e-3), "{widths:?}");
}

/// A ring over the blade tips from x = 9 on; without it, and where blades only lean over the passage, nothing is said.
#[test]
fn a_shroud_over_a_part_of_the_tips_is_refused() {
    let open = TestBlisk { blades: 48, shrouded: false, grid: [16, 16, 6, 2], ..Default::default() };
    for twist in [0.0, 0.5 / 56.0] {
        let channel = found(&TestBlisk { twist, ..open.clone() }.mesh());
        assert!(!channel.shrouded);
    }
    let ring = turned_part(&[[9.0, 61.5], [18.0, 61.5], [18.0, 66.0], [9.0, 66.0]], 240);
    let refusal = refused(&together(open.mesh(), &ring));
    assert!(refusal.contains("a shroud over a part of its length only"), "{refusal}");
}

/// A ring through all blades at mid span, and a ring over the outer part of blades between flat walls.
#[test]
fn rings_that_join_a_part_of_the_blades_are_refused() {
    let open = TestBlisk { blades: 48, shrouded: false, grid: [16, 16, 6, 2], ..Default::default() };
    let snubber = turned_part(&[[5.0, 57.0], [9.0, 57.0], [9.0, 58.0], [5.0, 58.0]], 240);
    let part = ParametricWheel { shrouded: false, ..coarse(ParametricWheel::nozzle_ring()) };
    let [inner, outer] = [0.0, 1.0].map(|along| part.place(along, 1.0));
    let (within, beyond) = (0.5 * (inner.y + outer.y), outer.y + 2.0);
    let [first, last] = [inner.x - 1.0, inner.x + 3.0];
    let cover = turned_part(&[[first, within], [last, within], [last, beyond], [first, beyond]], 240);
    for (mesh, ring) in [(open.mesh(), &snubber), (part.mesh(), &cover)] {
        let refusal = refused(&together(mesh, ring));
        assert!(refusal.contains("have a shroud, or a ring between them, only over"), "{refusal}");
    }
    // The way out that is told: a curve on this side of the ring.
    let drawn = [0.0, 5.0, 10.0, 15.0].map(|x| [x, 0.0, 56.8]).to_vec();
    let options = BliskOptions { shroud_points_mm: drawn, end_walls: EndWalls::Drawn, ..Default::default() };
    let channel = find(&together(open.mesh(), &snubber), &options).unwrap();
    assert_eq!(channel.blades, 48);
    assert!(channel.meridian.iter().all(|station| (station.shroud.y - 56.8).abs() < 1e-6), "{:?}", channel.meridian);
}

/// The blades of `part` between its walls, each made by `blade`.
fn with_blades(part: &ParametricWheel, blade: impl Fn(usize) -> Mesh) -> Mesh {
    (0..part.blades).map(blade).chain([part.wall(1.0)]).fold(part.wall(0.0), |all, one| together(all, &one))
}

#[test]
fn a_blade_that_is_a_tenth_of_a_millimetre_thicker_on_either_side_is_told() {
    for part in [ParametricWheel::nozzle_ring(), ParametricWheel::impeller()] {
        let thick = ParametricWheel { thickness_mm: part.thickness_mm + 0.2, ..part.clone() };
        let channel = found(&with_blades(&part, |k| if k == 4 { thick.blade(k) } else { part.blade(k) }));
        let told: Vec<usize> = channel.unlike.iter().map(|unlike| unlike.number).collect();
        assert_eq!(told.len(), 2, "{told:?} {:?}", channel.assumed);
        assert!(told[1] - told[0] == 1, "{told:?}");
    }
}

#[test]
fn blades_that_are_counted_anew_and_not_found_are_refused() {
    // Every other blade is thicker, and the hub ends before the blades do.
    let part = coarse(ParametricWheel::nozzle_ring());
    let thick = ParametricWheel { thickness_mm: 1.5 * part.thickness_mm, ..part.clone() };
    let [from, to] = [0.0, 1.0].map(|along| part.place(along, 0.0).y);
    let ring: Vec<DVec2> = (0..90)
        .map(|i| DVec2::from_angle(f64::from(i) / 90.0 * std::f64::consts::TAU) * (from.min(to) + 12.0))
        .collect();
    let bore = geometry::solid::prism(&[&ring], -100.0, 100.0).unwrap().mapped(|p| DVec3::new(p.z, p.x, p.y));
    let hub = geometry::solid::difference(&part.wall(0.0), &bore).unwrap();
    let blades = (0..part.blades).map(|k| if k % 2 == 0 { thick.blade(k) } else { part.blade(k) });
    let mesh = blades.chain([part.wall(1.0)]).fold(hub, |all, one| together(all, &one));
    let answer = find(&mesh, &BliskOptions::default());
    assert!(answer.is_err(), "{:?}", answer.map(|channel| channel.assumed));
}

#[test]
fn an_axis_that_is_asked_for_by_name_has_its_direction() {
    let tilted = DQuat::from_rotation_z(0.1f64.to_radians());
    let mesh = ParametricWheel::nozzle_ring().mesh().mapped(|p| tilted * p);
    let asked = BliskOptions { axis: AxisChoice::Named(AxisName::X), ..Default::default() };
    match find(&mesh, &asked) {
        Ok(channel) => assert_eq!(channel.frame.x, DVec3::X),
        Err(refusal) => assert!(refusal.to_string().contains("axis"), "{refusal}"),
    }
    assert!((found(&mesh).frame.x - tilted * DVec3::X).length() < 1e-6);
}

#[test]
fn blades_at_unequal_pitches_are_found_by_their_number() {
    let part = ParametricWheel { blades: 13, thickness_mm: 6.0, ..ParametricWheel::nozzle_ring() };
    let off_deg = |k: usize| [0.0, 2.0, -1.5, 1.0, -2.0, 1.5, -0.5f64][k * 3 % 7];
    let turned = |k: usize| DQuat::from_rotation_x(off_deg(k).to_radians());
    let mesh = with_blades(&part, |k| part.blade(k).mapped(|p| turned(k) * p));
    let options = BliskOptions { blades: Auto::Given(13), ..Default::default() };
    let channel = find(&mesh, &options).unwrap();
    assert_eq!((channel.blades, channel.kinds), (13, 13), "{:?}", channel.assumed);
    let frame = &channel.frame;
    assert!((frame.x - DVec3::X).length() < 5e-6 && frame.origin.length() < 2e-3, "{} {}", frame.x, frame.origin);
}

#[test]
fn spoilt_wheels_are_refused_or_told() {
    for part in [coarse(ParametricWheel::nozzle_ring()), coarse(ParametricWheel::impeller())] {
        let bladeless =
            ParametricWheel { flaws: Flaws { missing_blades: vec![4], ..Default::default() }, ..part.clone() }.mesh();
        assert!(find(&bladeless, &BliskOptions::default()).is_err(), "its gaps are not even");

        // Of 180 degrees without a shroud about half of the channels know nothing, and those at the ends less.
        let halved =
            ParametricWheel { flaws: Flaws { missing_shroud: 0.5, ..Default::default() }, ..part.clone() }.mesh();
        let answer = find(&halved, &BliskOptions::default());
        let told = answer.as_ref().map_or(0, |channel| channel.unlike.len());
        assert!(answer.is_err() || 2 * told + 4 >= part.blades, "{told} channels differ");

        let (sin, cos) = 2.0_f64.to_radians().sin_cos();
        let tilted = AxisLine { direction: [cos, sin, 0.0], point: [0.0; 3] };
        let options = BliskOptions { axis: AxisChoice::Line(tilted), ..Default::default() };
        let answer = find(&part.mesh(), &options);
        let told = answer.as_ref().map_or(0, |channel| channel.unlike.len());
        assert!(answer.is_err() || 2 * told >= part.blades, "{told} channels differ about the wrong axis");
    }
}

#[test]
fn a_splitter_in_the_middle_of_the_pitch_makes_its_neighbours_unlike() {
    let part = ParametricWheel {
        blades: 18,
        splitters: vec![Splitters::over([0.5, 0.95])],
        thickness_mm: 2.0,
        ..coarse(ParametricWheel::impeller())
    };
    let channel = found(&part.mesh());
    let others: Vec<usize> = (0..18).filter(|number| !channel.is_like(*number)).collect();
    assert_eq!(others, (0..9).map(|k| 2 * k + 1).collect::<Vec<_>>(), "{:?}", channel.assumed);
}

#[test]
fn one_turned_blade_of_few_makes_no_splitters() {
    let mesh = ParametricWheel {
        flaws: Flaws { turned_blade: Some((2, 0.02)), ..Default::default() },
        ..ParametricWheel::impeller()
    }
    .mesh();
    let channel = found(&mesh);
    assert_eq!((channel.kinds, channel.unlike.len()), (1, 2), "{:?}", channel.assumed);
}

#[test]
fn how_few_channels_are_like_the_found_one_is_said() {
    let said_of = |is_odd: bool, count: usize| {
        let unlike: Vec<Unlike> = (1..=count).map(|number| Unlike { number, difference: Difference::Tips }).collect();
        unlike_sentence(&unlike, is_odd, (24, 1), 0).unwrap()
    };
    let said = |count: usize| said_of(false, count);
    assert!(said(13).contains("Of the other 23 channels of its kind, 13 are not like this one: only 10 are."));
    assert!(said(23).contains("23 are not like this one: nor is any like another."));
    assert!(said_of(true, 23).contains("Channel 0 is the odd one: the other 23 of its kind are like each other"));
    assert!(said(2).contains("2 are not like this one (1 at 15.0 deg from this one: "), "{}", said(2));
}

/// Of every other blade only the lower half stands: beyond its tips nothing bounds the passage on one side.
#[test]
fn passages_between_a_high_and_a_low_blade_are_refused() {
    let part = coarse(ParametricWheel::nozzle_ring());
    let low = |k: usize| k % 2 == 1;
    // Between flat rings the height is along the axis.
    let [hub, shroud] = [0.0, 1.0].map(|height| part.place(0.5, height).x);
    let lowered = |p: DVec3| DVec3 { x: hub + 0.5 * (p.x - hub), ..p };
    let blade = |k: usize| if low(k) { part.blade(k).mapped(lowered) } else { part.blade(k) };
    let walls = together(part.wall(0.0), &part.wall(1.0));
    let mesh = (0..part.blades).map(blade).fold(walls, |all, one| together(all, &one));
    match find(&mesh, &BliskOptions::default()) {
        Err(BliskError::HigherBlade { x, .. }) => assert!(x > 0.5 * (hub + shroud) && x < shroud, "{x}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn metal_in_any_passage_is_told() {
    let part = TestBlisk::default();
    let lump = Mesh::cuboid(DVec3::splat(0.8)).mapped(|p| p - DVec3::splat(0.4));
    // In the middle between the two walls of a channel, as those are known from the generator.
    let in_channel = |k: usize| {
        let [low, high] = part.wall(7.0, 56.0);
        let theta = 0.5 * (low + high) + k as f64 * part.pitch();
        lump.mapped(|p| p + Cylindrical { x: 7.0, r: 56.0, theta }.point())
    };
    // The number of the passage with the lump; none where the chosen one is refused for it.
    let told = |mesh: &Mesh, channel: usize| match find(mesh, &BliskOptions { channel, ..Default::default() }) {
        Err(BliskError::Obstructed { .. }) => None,
        Ok(Channel { unlike, .. }) => match unlike[..] {
            [Unlike { number, difference: Difference::Obstructed { off_mm } }] if off_mm > 1.0 => Some(number),
            _ => panic!("{unlike:?}"),
        },
        Err(error) => panic!("{error}"),
    };
    // Passages are counted from the one whose middle is on +Z of W.
    let frame = found(&part.mesh()).frame;
    let number = |lump: &Mesh| {
        let middle = Cylindrical::from_point(frame.from_parent(lump.bounds().center()));
        (middle.theta / part.pitch()).round().rem_euclid(part.blades as f64) as usize
    };
    for (chosen, k) in [(0, 0), (0, 1), (0, 23), (5, 12)] {
        let lump = in_channel(k);
        let (told, number) = (told(&together(part.mesh(), &lump), chosen), number(&lump));
        assert_eq!(told, (number != chosen).then_some(number), "channel {chosen}, a lump in {k}");
    }
}

/// Beside splitters every other passage is of the chosen kind.
#[test]
fn metal_in_a_passage_beside_splitters_is_told() {
    let splitters = vec![Splitters::over([0.3, 0.95])];
    let part = ParametricWheel { blades: 12, splitters, ..coarse(ParametricWheel::impeller()) };
    let lump = Mesh::cuboid(DVec3::splat(1.5)).mapped(|p| p - DVec3::splat(0.75));
    let number = |k: usize| {
        let [low, high] = part.walls(k, 0.7, 0.5).unwrap();
        let DVec2 { x, y: r } = part.place(0.7, 0.5);
        let at = Cylindrical { x, r, theta: 0.5 * (low + high) }.point();
        match find(&together(part.mesh(), &lump.mapped(|p| p + at)), &BliskOptions::default()) {
            Err(BliskError::Obstructed { .. }) => Some(0),
            Ok(Channel { kinds: 2, unlike, .. }) => match unlike[..] {
                [Unlike { number, difference: Difference::Obstructed { .. } }] => Some(number),
                _ => None,
            },
            other => panic!("{other:?}"),
        }
    };
    let numbers = [0, 1, 2, 3].map(number);
    // Two of them are of its kind, and are numbered in their order.
    let ([Some(one), None, Some(next), None] | [None, Some(one), None, Some(next)]) = numbers else {
        panic!("{numbers:?}")
    };
    assert!(one % 2 == 0 && next == (one + 2) % part.blades, "{numbers:?}");
}

/// A passage that differs by a wall and by metal in it is told by the metal.
#[test]
fn metal_is_told_before_a_wall_that_differs() {
    let flaws = Flaws { turned_blade: Some((2, 0.02)), ..Default::default() };
    let part = ParametricWheel { flaws, ..coarse(ParametricWheel::impeller()) };
    let [low, high] = part.walls(2, 0.6, 0.5).unwrap();
    let DVec2 { x, y: r } = part.place(0.6, 0.5);
    let at = Cylindrical { x, r, theta: 0.5 * (low + high) }.point();
    let lump = Mesh::cuboid(DVec3::splat(1.5)).mapped(|p| p + at - DVec3::splat(0.75));
    let mesh = together(part.mesh(), &lump);
    let options = |channel| BliskOptions { channel, ..Default::default() };
    let sound: Vec<Channel> = (0..part.blades).step_by(4).filter_map(|k| find(&mesh, &options(k)).ok()).collect();
    assert!(!sound.is_empty());
    for channel in sound.iter().filter(|channel| channel.unlike.len() == 2) {
        let metal = |unlike: &&Unlike| matches!(unlike.difference, Difference::Obstructed { .. });
        assert_eq!(channel.unlike.iter().filter(metal).count(), 1, "{:?}", channel.unlike);
    }
    assert!(sound.iter().any(|channel| channel.unlike.len() == 2));
}

#[test]
fn another_row_of_as_many_blades_is_told() {
    let part = TestBlisk::default();
    let behind = part.mesh().mapped(|p| p + DVec3::X * (part.chord + 2.0 * part.beside));
    let channel = found(&together(part.mesh(), &behind));
    let told = |channel: &Channel| channel.assumed.iter().any(|s| s.starts_with("Another row of 24 blades"));
    assert!(told(&channel), "{:?}", channel.assumed);
    // Main blades ahead of their splitters are no other row.
    let splitters = vec![Splitters::over([0.5, 0.95])];
    let one = found(&ParametricWheel { splitters, ..ParametricWheel::impeller() }.mesh());
    assert!(!one.assumed.iter().any(|s| s.starts_with("Another row")), "{:?}", one.assumed);
}

#[test]
fn tips_that_end_before_a_shroud_are_told() {
    let open = TestBlisk { blades: 48, shrouded: false, grid: [16, 16, 6, 2], ..Default::default() };
    let ring = |inner: f64| turned_part(&[[-3.0, inner], [17.0, inner], [17.0, 66.0], [-3.0, 66.0]], 240);
    let gap = |inner: f64| {
        let channel = found(&together(open.mesh(), &ring(inner)));
        assert!(channel.shrouded);
        let said = channel.assumed.iter().find_map(|s| s.strip_prefix("The blades end up to ")).map(str::to_owned);
        said.map(|s| s.split(' ').next().and_then(|mm| mm.parse::<f64>().ok()).unwrap())
    };
    // Less the sag of the ring's facets, more by that of the tips.
    let wide = gap(62.3).unwrap();
    assert!((0.28..0.33).contains(&wide), "{wide}");
    assert_eq!(gap(61.9), None, "they reach into it");
    // A ray along the radius leaves a thin blade that leans by its side.
    let aslant = found(&ParametricWheel { thickness_mm: 1.0, lean: 0.1, ..ParametricWheel::nozzle_ring() }.mesh());
    assert!(!aslant.assumed.iter().any(|s| s.starts_with("The blades end")), "{:?}", aslant.assumed);
}

#[test]
fn what_a_given_hub_leaves_is_told() {
    let mesh = TestBlisk { grid: [96, 8, 8, 2], ..Default::default() }.mesh();
    let channel = find(&mesh, &BliskOptions { hub_radius_mm: Auto::Given(53.0), ..Default::default() }).unwrap();
    let hub = channel.agreement.iter().find(|a| a.surface == Surface::Hub).unwrap();
    assert!((hub.left_mm - 3.0).abs() < 0.02, "{hub:?}");
    assert!(
        channel.assumed.iter().any(|s| s.starts_with("The hub of the mesh lies up to 3.0")),
        "{:?}",
        channel.assumed
    );
    assert!(found(&mesh).agreement.iter().all(|a| a.left_mm == 0.0));
    // The true radius leaves nothing, however coarse the facets, and whatever holes the hub has.
    let part = TestBlisk { grid: [8, 8, 8, 2], ..Default::default() };
    let ring: Vec<DVec2> = (0..12).map(|i| DVec2::from_angle(TAU * f64::from(i) / 12.0)).collect();
    let drill = geometry::solid::prism(&[&ring], 44.0, 54.0).unwrap();
    let [low, high] = part.wall(7.0, 50.0);
    let out = Cylindrical { x: 0.0, r: 1.0, theta: 0.5 * (low + high) }.point();
    let drill = drill.mapped(|p| (7.0 + p.x) * DVec3::X + p.y * out.cross(DVec3::X) + p.z * out);
    let drilled = geometry::solid::difference(&part.mesh(), &drill);
    for mesh in [part.mesh(), drilled.unwrap()] {
        let options = BliskOptions { hub_radius_mm: Auto::Given(50.0), ..Default::default() };
        let channel = find(&mesh, &options).unwrap();
        assert!(!channel.assumed.iter().any(|s| s.contains("is not burned")), "{:?}", channel.assumed);
    }
}

/// The hub of a fan is small beside its reach, and its blades cover less than the whole turn.
#[test]
fn an_open_wheel_with_a_small_hub_goes_all_the_way_round() {
    let fan = TestBlisk {
        blades: 7,
        hub: [30.0, 0.0],
        shroud: [100.0, 0.0],
        bore: 10.0,
        shrouded: false,
        grid: [24, 16, 8, 2],
        ..Default::default()
    };
    let channel = found(&fan.mesh());
    assert_eq!((channel.blades, channel.shrouded), (7, false));
}

#[test]
fn uneven_pitches_are_named_as_the_reason() {
    let part = TestBlisk { blades: 9, grid: [24, 8, 24, 2], ..Default::default() };
    for most in [0.02, 0.06] {
        let uneven = part.mesh().mapped(|p| {
            let Cylindrical { x, r, theta } = Cylindrical::from_point(p);
            Cylindrical { x, r, theta: theta + most * (2.0 * theta).sin() }.point()
        });
        let said = refused(&uneven);
        assert!(said.contains("not evenly spaced"), "{most}: {said}");
    }
}

/// With axis and number given, every passage of blades at unequal angles is found for itself.
#[test]
fn blades_at_unequal_angles_are_found_by_hand() {
    let part = TestBlisk { blades: 9, grid: [24, 8, 24, 2], ..Default::default() };
    // The angle of a place on the evenly spaced wheel; it grows with that on the uneven one.
    let uneven = |theta: f64| theta + 0.08 * (2.0 * theta).sin();
    let mesh = part.mesh().mapped(|p| {
        let Cylindrical { x, r, theta } = Cylindrical::from_point(p);
        Cylindrical { x, r, theta: uneven(theta) }.point()
    });
    let line = AxisLine { direction: [1.0, 0.0, 0.0], point: [0.0; 3] };
    let options = BliskOptions { axis: AxisChoice::Line(line), blades: Auto::Given(9), ..Default::default() };
    let even = found(&part.mesh());
    let walls = |channel: &Channel| [&channel.low, &channel.high].map(|wall| wall.cylindrical(40, 12).theta);
    let middle = |channel: &Channel| (-channel.frame.z.y).atan2(channel.frame.z.z);
    for number in 0..9 {
        let channel = find(&mesh, &BliskOptions { channel: number, ..options.clone() }).unwrap();
        assert_eq!((channel.blades, channel.kinds, channel.unlike.len()), (9, 9, 0));
        // Both walls are where those of the even wheel went.
        let at = middle(&even) + TAU * number as f64 / 9.0;
        let expected = walls(&even).map(|theta| uneven(at + theta) - middle(&channel));
        for (wall, expected) in walls(&channel).into_iter().zip(expected) {
            assert!(wrap_angle(wall - expected).abs() < 1e-3, "channel {number}: {wall} rad for {expected}");
        }
    }
}
