//! A wheel of any direction of flow from a few numbers.
//!
//! Walls of revolution about curves from inlet to outlet, blades that wind about the axis between them, rings with seal
//! teeth and bolted flanges: each a closed shell of its own, reaching into its neighbours as solids in an assembly do.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec2, DVec3};

use super::welder::Welder;
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;

/// A curve in the half plane (x, r): a cubic Bézier curve over a share from 0 at the inlet to 1 at the outlet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeridianCurve(pub [DVec2; 4]);

impl MeridianCurve {
    /// The straight line between two places.
    pub fn line(from: DVec2, to: DVec2) -> Self {
        Self([from, from.lerp(to, 1.0 / 3.0), from.lerp(to, 2.0 / 3.0), to])
    }

    /// A quarter of an ellipse, or of a circle within 0.03 % of its radius, that leaves `from` along `way`.
    pub fn quarter(from: DVec2, way: DVec2, to: DVec2) -> Self {
        const KAPPA: f64 = 0.552_284_749_830_793_4;
        let way = way.normalize_or(DVec2::X);
        let corner = from + way * (to - from).dot(way);
        Self([from, from.lerp(corner, KAPPA), to.lerp(corner, KAPPA), to])
    }

    /// Place at a share.
    pub fn at(&self, share: f64) -> DVec2 {
        let [a, b, c, d] = self.0;
        let (t, s) = (share, 1.0 - share);
        a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t)
    }
}

/// A kind of splitter blades, of which one follows every main blade.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Splitters {
    /// Shares of the passage between which they stand.
    pub span: [f64; 2],
    /// Angle by which they stand off their place in the even pitch (rad).
    pub off_middle: f64,
    /// Thickness, as a share of that of the main blades.
    pub thickness: f64,
}

impl Splitters {
    /// As thick as the main blades, in the even pitch.
    pub fn over(span: [f64; 2]) -> Self {
        Self { span, off_middle: 0.0, thickness: 1.0 }
    }
}

/// Place and thickness of one blade.
#[derive(Clone, Copy)]
struct Blade {
    /// Shares of the passage between which it stands.
    span: [f64; 2],
    /// Angle where its middle begins (rad).
    begin: f64,
    /// Thickness, as a share of that of the main blades.
    thickness: f64,
}

/// What is wrong with a wheel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Flaws {
    /// A blade, turned about the axis by an angle (rad).
    pub turned_blade: Option<(usize, f64)>,
    /// Blades that are not there.
    pub missing_blades: Vec<usize>,
    /// Share of the turn over which there is no shroud.
    pub missing_shroud: f64,
    /// A blade that is bent about the axis, most half way up under a shroud and at the tip without one, by so much (mm).
    pub bent_blade: Option<(usize, f64)>,
}

/// A wheel about X.
#[derive(Debug, Clone, PartialEq)]
pub struct ParametricWheel {
    /// Number of blades, splitters included.
    pub blades: usize,
    /// The hub (mm).
    pub hub: MeridianCurve,
    /// The shroud or the tips (mm).
    pub shroud: MeridianCurve,
    /// Whether there is a shroud.
    pub shrouded: bool,
    /// Shares of the passage between which the blades stand.
    pub span: [f64; 2],
    /// The blades that follow every main blade, in this order.
    pub splitters: Vec<Splitters>,
    /// How fast a blade winds about the axis at the inlet and at the outlet, the rate changing evenly between
    /// (rad over the whole passage).
    pub wrap: [f64; 2],
    /// Angle by which a blade's end at the shroud is ahead of that at the hub (rad).
    pub lean: f64,
    /// Thickness of a blade along the circumference, midway between its edges (mm).
    pub thickness_mm: f64,
    /// Thickness of a blade at its edges, as a share of that midway.
    pub edge_thickness: f64,
    /// Share of the passage over which an edge of a blade is rounded; 0 for a flat edge.
    pub nose: f64,
    /// Radius of the fillets between blades and walls, along the circumference (mm); at most 0.3 of the height.
    pub fillet_mm: f64,
    /// Whether fillets go round the edges of the blades as well.
    pub fillets_round_edges: bool,
    /// Thickness of the walls (mm).
    pub wall_mm: f64,
    /// Seal teeth on the back of the shroud.
    pub teeth: usize,
    /// Holes in a flange at the inlet, within the hub.
    pub holes: usize,
    /// What is wrong with it.
    pub flaws: Flaws,
    /// Pieces about the axis, along the passage and across it.
    pub pieces: [usize; 3],
    /// Pieces of a fillet.
    pub fillet_pieces: usize,
}

impl ParametricWheel {
    /// How far blades reach into walls, as a share of the height.
    const INTO: f64 = 0.1;

    /// The built-in demonstration: a shrouded axial turbine wheel of moderate turning whose electrode comes out in one
    /// part.
    pub fn demonstration() -> Self {
        let at = DVec2::new;
        Self {
            blades: 44,
            hub: MeridianCurve([at(-4.0, 96.0), at(5.0, 95.2), at(15.0, 95.2), at(24.0, 96.4)]),
            shroud: MeridianCurve([at(-4.0, 111.4), at(5.0, 111.6), at(15.0, 112.2), at(24.0, 113.4)]),
            span: [9.0 / 64.0, 55.0 / 64.0],
            // Blade angles of 30 and -40 degrees at the edges.
            wrap: [0.231, -0.303],
            lean: 0.003,
            thickness_mm: 3.4,
            edge_thickness: 0.4,
            nose: 0.03,
            fillet_mm: 0.6,
            wall_mm: 5.0,
            teeth: 6,
            holes: 11,
            pieces: [176, 24, 3],
            fillet_pieces: 4,
            ..Self::nozzle_ring()
        }
    }

    /// A ring of blades between two flat rings 12 mm apart.
    pub fn nozzle_ring() -> Self {
        let across = |x: f64| MeridianCurve::line(DVec2::new(x, 68.0), DVec2::new(x, 104.0));
        Self {
            blades: 20,
            hub: across(0.0),
            shroud: across(12.0),
            shrouded: true,
            span: [0.1, 0.9],
            splitters: Vec::new(),
            wrap: [0.5; 2],
            lean: 0.0,
            thickness_mm: 3.0,
            edge_thickness: 1.0,
            nose: 0.0,
            fillet_mm: 0.0,
            fillets_round_edges: false,
            wall_mm: 5.0,
            teeth: 0,
            holes: 0,
            flaws: Flaws::default(),
            pieces: [200, 64, 8],
            fillet_pieces: 8,
        }
    }

    /// A closed impeller whose passage turns by a right angle from along the axis to along the radius, about the point
    /// (-30, 70).
    pub fn impeller() -> Self {
        let arc = |radius: f64| {
            let (from, to) = (DVec2::new(-30.0, 70.0 - radius), DVec2::new(-30.0 + radius, 70.0));
            MeridianCurve::quarter(from, DVec2::X, to)
        };
        Self { blades: 9, hub: arc(50.0), shroud: arc(34.0), span: [0.1, 0.95], wrap: [1.2; 2], ..Self::nozzle_ring() }
    }

    /// Angle from blade to blade (rad).
    pub fn pitch(&self) -> f64 {
        TAU / self.blades as f64
    }

    /// Place (x, r) at a share of the passage and of the height (mm).
    pub fn place(&self, along: f64, height: f64) -> DVec2 {
        self.hub.at(along).lerp(self.shroud.at(along), height)
    }

    /// Number of kinds of blades.
    pub fn kinds(&self) -> usize {
        1 + self.splitters.len()
    }

    /// Shares of the passage between which every blade stands.
    pub fn span_of_all(&self) -> [f64; 2] {
        let spans = self.splitters.iter().map(|s| s.span);
        spans.fold(self.span, |[from, to], span| [from.max(span[0]), to.min(span[1])])
    }

    /// What blade `k` is of, if it is a splitter.
    pub fn splitter(&self, k: usize) -> Option<&Splitters> {
        (k % self.kinds()).checked_sub(1).map(|kind| &self.splitters[kind])
    }

    /// Where blade `k` stands and how thick it is.
    fn blade_at(&self, k: usize) -> Blade {
        let turned = self.flaws.turned_blade.filter(|(blade, _)| *blade == k).map_or(0.0, |(_, turn)| turn);
        let main = Splitters::over(self.span);
        let Splitters { span, off_middle, thickness } = *self.splitter(k).unwrap_or(&main);
        Blade { span, begin: self.pitch() * k as f64 + turned + off_middle, thickness }
    }

    /// Angle that a blade has wound about the axis up to a share of the passage (rad).
    fn wound(&self, along: f64) -> f64 {
        let [from, to] = self.wrap;
        from * along + 0.5 * (to - from) * along * along
    }

    /// Angle by which blade `k` leans about the axis at shares of the passage and of the height (rad).
    fn leant(&self, k: usize, [along, height]: [f64; 2]) -> f64 {
        let bent = self.flaws.bent_blade.filter(|(blade, _)| *blade == k).map_or(0.0, |(_, mm)| {
            let bow = if self.shrouded { 4.0 * height * (1.0 - height) } else { height * height };
            mm * bow / self.place(along, height).y
        });
        self.lean * height + bent
    }

    /// How far fillets stand off a blade at a share of the passage and of the height (mm).
    fn fillet(&self, along: f64, height: f64) -> f64 {
        let span_mm = self.hub.at(along).distance(self.shroud.at(along));
        let fillet = |off: f64| {
            let k = (1.0 - off.max(0.0) / self.fillet_mm.max(1e-300)).clamp(0.0, 1.0);
            self.fillet_mm * (1.0 - (1.0 - k * k).sqrt())
        };
        fillet(height * span_mm) + if self.shrouded { fillet((1.0 - height) * span_mm) } else { 0.0 }
    }

    /// The shares of the passage between which a blade over `span` stands at a share of the height, fillets included.
    fn span_at(&self, span: [f64; 2], height: f64) -> [f64; 2] {
        if !self.fillets_round_edges {
            return span;
        }
        let length = self.place(span[0], height).distance(self.place(span[1], height)) / (span[1] - span[0]);
        [span[0] - self.fillet(span[0], height) / length, span[1] + self.fillet(span[1], height) / length]
    }

    /// Half the thickness of a blade at a share of the passage and of the height, fillets included (mm).
    fn half_thickness(&self, Blade { span, thickness, .. }: Blade, along: f64, height: f64) -> f64 {
        let span = self.span_at(span, height);
        let from_end = (along - span[0]).min(span[1] - along).max(0.0);
        let nose = match self.nose {
            nose if from_end >= nose => 1.0,
            nose => (1.0 - (1.0 - from_end / nose).powi(2)).sqrt(),
        };
        let off_middle = (2.0 * along - span[0] - span[1]) / (span[1] - span[0]);
        let tapered = 1.0 - (1.0 - self.edge_thickness) * off_middle * off_middle;
        nose * (0.5 * self.thickness_mm * thickness * tapered + self.fillet(along, height))
    }

    /// Angles of the low and the high wall of the passage above blade `k`, at a share of the passage and of the height
    /// (rad); none where one of the blades does not stand.
    pub fn walls(&self, k: usize, along: f64, height: f64) -> Option<[f64; 2]> {
        let r = self.place(along, height).y;
        let wall = |blade: usize, side: f64| {
            let of = self.blade_at(blade % self.blades);
            let turns = if blade >= self.blades { TAU } else { 0.0 };
            let stands = !self.flaws.missing_blades.contains(&(blade % self.blades));
            let at = self.span_at(of.span, height);
            (stands && (at[0]..=at[1]).contains(&along)).then(|| {
                let middle = of.begin + turns + self.wound(along) + self.leant(blade % self.blades, [along, height]);
                middle + side * self.half_thickness(of, along, height) / r
            })
        };
        Some([wall(k, 1.0)?, wall(k + 1, -1.0)?])
    }

    /// All shells together, about X.
    pub fn mesh(&self) -> Mesh {
        let mut shells = vec![self.wall(0.0)];
        if self.shrouded {
            shells.push(self.wall(1.0));
        }
        let standing = (0..self.blades).filter(|k| !self.flaws.missing_blades.contains(k));
        shells.extend(standing.map(|k| self.blade(k)));
        shells.extend((self.holes > 0).then(|| self.flange()));
        together(shells)
    }

    /// All shells together, moved.
    pub fn mesh_at(&self, placement: DAffine3) -> Mesh {
        let mut mesh = self.mesh();
        mesh.vertices.iter_mut().for_each(|p| *p = placement.transform_point3(*p));
        mesh
    }

    /// The wall of revolution at a height of 0 or 1, thick away from the passage.
    pub(crate) fn wall(&self, height: f64) -> Mesh {
        let [around, along, _] = self.pieces;
        let away = if height > 0.5 { 1.0 } else { -1.0 };
        let share = |i: usize| i as f64 / along as f64;
        let front = (0..=along).map(|i| self.place(share(i), height));
        let teeth = if height > 0.5 { self.teeth } else { 0 };
        let back = (0..=along).rev().map(|i| {
            let up = (self.shroud.at(share(i)) - self.hub.at(share(i))).normalize();
            // A tooth is a third of its division wide.
            let is_tooth = teeth > 0 && (share(i) * teeth as f64).fract() < 1.0 / 3.0;
            let thick = self.wall_mm * if is_tooth { 1.4 } else { 1.0 };
            self.place(share(i), height) + away * thick * up
        });
        let outline: Vec<DVec2> = front.chain(back).collect();
        let missing = if height > 0.5 { self.flaws.missing_shroud } else { 0.0 };
        turned(&outline, around, (around as f64 * (1.0 - missing)).round() as usize, along)
    }

    /// A flange with round holes at the inlet, from within the hub's wall inwards.
    fn flange(&self) -> Mesh {
        let start = self.hub.at(0.0);
        let outer = (start.y - 0.5 * self.wall_mm).max(0.5 * start.y);
        let inner = 0.4 * outer;
        let thick = flange(inner, outer, self.holes, 0.15 * (outer - inner));
        thick.mapped(|p| DVec3::new(start.x + self.wall_mm * (p.x / 10.0 - 0.5), p.y, p.z))
    }

    /// Blade `k`.
    pub(crate) fn blade(&self, k: usize) -> Mesh {
        let [_, along, across] = self.pieces;
        let blade = self.blade_at(k);
        // Close together where edges are round.
        let shares: Vec<f64> = (0..=along)
            .map(|i| i as f64 / along as f64)
            .map(|s| if self.nose > 0.0 { 0.5 - 0.5 * (PI * s).cos() } else { s })
            .collect();
        let heights = self.heights(across);
        let n = heights.len() - 1;
        let point = |(i, v, side): (usize, usize, f64)| {
            let within = |[from, to]: [f64; 2]| from + (to - from) * shares[i];
            let t = within(blade.span);
            let height_mm = self.hub.at(t).distance(self.shroud.at(t));
            let height = match heights[v] {
                Height::Share(share) => share,
                Height::AboveHub(mm) => mm / height_mm,
                Height::BelowShroud(mm) => 1.0 - mm / height_mm,
            };
            let t = within(self.span_at(blade.span, height.clamp(0.0, 1.0)));
            let place = self.place(t, height);
            let half = self.half_thickness(blade, t, height.clamp(0.0, 1.0));
            let theta = blade.begin + self.wound(t) + self.leant(k, [t, height]) + side * half / place.y;
            Cylindrical { x: place.x, r: place.y, theta }.point()
        };
        let mut quads = Vec::new();
        for (i, v) in (0..along).flat_map(|i| (0..n).map(move |v| (i, v))) {
            quads.push([(i, v, 1.0), (i + 1, v, 1.0), (i + 1, v + 1, 1.0), (i, v + 1, 1.0)]);
            quads.push([(i, v, -1.0), (i, v + 1, -1.0), (i + 1, v + 1, -1.0), (i + 1, v, -1.0)]);
        }
        for v in 0..n {
            quads.push([(0, v, -1.0), (0, v, 1.0), (0, v + 1, 1.0), (0, v + 1, -1.0)]);
            quads.push([(along, v, 1.0), (along, v, -1.0), (along, v + 1, -1.0), (along, v + 1, 1.0)]);
        }
        for i in 0..along {
            quads.push([(i, 0, -1.0), (i + 1, 0, -1.0), (i + 1, 0, 1.0), (i, 0, 1.0)]);
            quads.push([(i, n, 1.0), (i + 1, n, 1.0), (i + 1, n, -1.0), (i, n, -1.0)]);
        }
        let mut welder = Welder::default();
        quads.into_iter().for_each(|quad| welder.quad(quad.map(point)));
        outwards(welder.mesh)
    }

    /// Heights of a blade's rows: into the walls, close together in the fillets, up to the tips where there is no
    /// shroud.
    fn heights(&self, across: usize) -> Vec<Height> {
        let fillet = |i: usize| self.fillet_mm * (1.0 - (0.5 * PI * i as f64 / self.fillet_pieces as f64).cos());
        let rounds = if self.fillet_mm > 0.0 { self.fillet_pieces } else { 0 };
        let mut heights = vec![Height::Share(-Self::INTO), Height::Share(0.0)];
        heights.extend((1..=rounds).map(|i| Height::AboveHub(fillet(i))));
        let [from, to] = if self.fillet_mm > 0.0 { [0.3, if self.shrouded { 0.7 } else { 1.0 }] } else { [0.0, 1.0] };
        heights.extend((1..across).map(|v| Height::Share(from + (to - from) * v as f64 / across as f64)));
        if self.shrouded {
            heights.extend((1..=rounds).rev().map(|i| Height::BelowShroud(fillet(i))));
        }
        heights.push(Height::Share(1.0));
        heights.extend(self.shrouded.then_some(Height::Share(1.0 + Self::INTO)));
        heights
    }
}

/// Where a row of a blade runs.
#[derive(Debug, Clone, Copy)]
enum Height {
    /// At a share of the height.
    Share(f64),
    /// Above the hub (mm).
    AboveHub(f64),
    /// Below the shroud (mm).
    BelowShroud(f64),
}

/// All shells as one mesh.
pub(crate) fn together(shells: impl IntoIterator<Item = Mesh>) -> Mesh {
    let mut all = Mesh::default();
    for shell in shells {
        let first = all.vertices.len() as u32;
        all.vertices.extend(shell.vertices);
        all.triangles.extend(shell.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

/// The outline of (x, r), of which the first `along + 1` points are the front and the others the back, turned about X by
/// so many of `around` steps.
pub(crate) fn turned(outline: &[DVec2], around: usize, steps: usize, along: usize) -> Mesh {
    let n = outline.len();
    let point = |(j, i): (usize, usize)| {
        let DVec2 { x, y: r } = outline[i % n];
        Cylindrical { x, r, theta: TAU * (j % around) as f64 / around as f64 }.point()
    };
    let sides = (0..steps).flat_map(|j| (0..n).map(move |i| [(j, i), (j + 1, i), (j + 1, i + 1), (j, i + 1)]));
    // The front of the outline runs forth, its back runs back.
    let cap = |j: usize| (0..along).map(move |i| [(j, i), (j, i + 1), (j, n - 2 - i), (j, n - 1 - i)]);
    let caps = cap(0).chain(cap(steps).map(|[a, b, c, d]| [d, c, b, a])).filter(|_| steps < around);
    let mut welder = Welder::default();
    sides.chain(caps).for_each(|quad| welder.quad(quad.map(point)));
    outwards(welder.mesh)
}

/// A flat ring with `holes` round holes through it, 10 mm thick, as bolted on shafts.
pub fn flange(inner: f64, outer: f64, holes: usize, hole_radius: f64) -> Mesh {
    const AROUND: usize = 32;
    let mut w = Welder::default();
    let half = PI / holes as f64;
    let middle = 0.5 * (inner + outer);
    for k in 0..holes {
        let turn = 2.0 * half * k as f64;
        // The hole's rim and the sector's border, each in as many points, counter-clockwise seen from +X.
        let rim = |j: usize| {
            let (s, c) = (TAU * j as f64 / AROUND as f64).sin_cos();
            [middle + hole_radius * c, hole_radius / middle * s]
        };
        let border = |j: usize| {
            let (s, c) = (TAU * (j % AROUND) as f64 / AROUND as f64).sin_cos();
            let k = 1.0 / s.abs().max(c.abs());
            [middle + 0.5 * (outer - inner) * k * c, half * k * s]
        };
        let at = |x: f64, [r, theta]: [f64; 2]| Cylindrical { x, r, theta: theta + turn }.point();
        let pick = |i: usize, j: usize| if i == 0 { rim(j) } else { border(j) };
        w.patch(AROUND, 1, |j, i| at(10.0, pick(i, j)));
        w.patch(1, AROUND, |i, j| at(0.0, pick(i, j)));
        w.patch(AROUND, 1, |j, i| at(10.0 * i as f64, rim(j)));
        for j in 0..AROUND {
            let (a, b) = (border(j), border(j + 1));
            if (a[0] - b[0]).abs() < 1e-9 && (a[0] - middle).abs() > 0.49 * (outer - inner) {
                w.patch(1, 1, |t, i| at(10.0 * (1 - i) as f64, if t == 0 { a } else { b }));
            }
        }
    }
    w.mesh
}

/// A closed shell, oriented outwards.
pub(crate) fn outwards(mut mesh: Mesh) -> Mesh {
    if mesh.volume() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}
