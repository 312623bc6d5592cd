//! Parameters of electrodes.

use std::f64::consts::FRAC_1_SQRT_2;

use files::{Invalid, Override, Validate};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::finding::CheckKind;
use super::given::GivenName;
use crate::cutter::CutterLibrary;
use burning::choice::Until;
use burning::project::ProjectTechnology;

/// A motion of the machine that widens the burn, in a plane across the burn direction.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "pattern", deny_unknown_fields)]
pub enum Orbit {
    /// No orbit.
    #[default]
    None,
    /// A circle.
    Circular {
        /// Radius (mm).
        radius_mm: f64,
    },
    /// A square with its sides along X and Y.
    Square {
        /// Half its side (mm).
        radius_mm: f64,
    },
}

impl Orbit {
    /// Distance along a face's unit normal by which the orbit extends the burn (mm).
    pub fn reach(self, normal: DVec3) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Circular { radius_mm } => radius_mm * normal.truncate().length(),
            Self::Square { radius_mm } => radius_mm * (normal.x.abs() + normal.y.abs()),
        }
    }

    /// Whether an electrode made for this orbit also suits it when turned about the burn direction (radians): the
    /// machine does not turn the orbit.
    pub fn fits_turned(self, turn: f64) -> bool {
        /// Rounding of a quarter turn (rad).
        const HAIR: f64 = 1e-6;
        let quarters = turn / std::f64::consts::FRAC_PI_2;
        !matches!(self, Self::Square { .. }) || (quarters - quarters.round()).abs() < HAIR
    }

    /// The point of the orbit nearest to `p`, in the plane about its middle (mm).
    pub fn nearest(self, p: DVec2) -> DVec2 {
        match self {
            Self::None => DVec2::ZERO,
            Self::Circular { radius_mm } => p.clamp_length_max(radius_mm),
            Self::Square { radius_mm } => p.clamp(DVec2::splat(-radius_mm), DVec2::splat(radius_mm)),
        }
    }

    /// Radius or half side (mm).
    pub fn radius_mm(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Circular { radius_mm } | Self::Square { radius_mm } => radius_mm,
        }
    }
}

/// A stage: one of the burns of a place, each with an electrode of its own size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// Name: rough, finish.
    pub name: String,
    /// Spark gap (mm): distance between electrode and burned surface.
    pub gap_mm: f64,
    /// Stock left for the stages after this one (mm), on every face.
    #[serde(default)]
    pub stock_mm: f64,
    /// The orbit.
    #[serde(default)]
    pub orbit: Orbit,
    /// Required surface finish (VDI 3400).
    #[serde(default = "usual_finish")]
    pub finish_vdi: f64,
    /// Name of the step of the technology at which burning ends; empty to end at the finish.
    #[serde(default)]
    pub last_step: String,
    /// Number of electrodes to make.
    #[serde(default = "one")]
    pub quantity: u32,
}

fn usual_finish() -> f64 {
    24.0
}

fn one() -> u32 {
    1
}

impl Stage {
    /// A finishing burn with this gap (mm).
    pub fn finish(gap_mm: f64) -> Self {
        Self {
            name: "finish".into(),
            gap_mm,
            stock_mm: 0.0,
            orbit: Orbit::None,
            finish_vdi: usual_finish(),
            last_step: String::new(),
            quantity: one(),
        }
    }

    /// Distance of the electrode from a face with this unit normal (mm): gap, stock and orbit.
    pub fn undersize(&self, normal: DVec3) -> f64 {
        self.gap_mm + self.stock_mm + self.orbit.reach(normal)
    }

    /// Greatest distance from an upright face (mm); with a square orbit from a face aslant.
    pub fn most_across(&self) -> f64 {
        [DVec3::X, DVec3::new(FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0)]
            .map(|n| self.undersize(n))
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// End of burning: the last step, or else the finish.
    pub fn until(&self) -> Until {
        match self.last_step.trim() {
            "" => Until::Vdi(self.finish_vdi),
            step => Until::Step(step.to_owned()),
        }
    }

    /// Roughness Ra of the finish (micrometres; VDI 3400: 20 log10 of ten times it).
    pub fn roughness_um(&self) -> f64 {
        10f64.powf(self.finish_vdi / 20.0) / 10.0
    }
}

/// Shape in electrode files.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// The electrode as milled: smaller than the cavity by gap and orbit.
    #[default]
    Undersized,
    /// The shape of the cavity; the gap is an attribute, and the electrode is milled that much smaller.
    Net,
}

/// Method of making a tip from a region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Extrudes the region's own outline: for regions of whole faces.
    Extruding,
    /// Trims a box around the region by the faces: for regions with parts of faces.
    Cutting,
}

/// Inner edges of heads at which regions are divided.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DividedAt {
    /// Nowhere: a head for each region, whatever edges it has.
    Nothing,
    /// Every inner edge, also those that a flat end mills.
    EveryEdge,
    /// Inner edges that no cutter mills.
    #[default]
    HEdges,
}

/// A holder for electrodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Holder {
    /// Name.
    pub name: String,
    /// Largest blank, along X and Y (mm).
    pub size_mm: [f64; 2],
    /// Height above the blank (mm).
    pub height_mm: f64,
}

/// Sizes of blanks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Blanks {
    /// Sides of rectangular blanks (mm), rising; larger sides are rounded up.
    pub sides_mm: Vec<f64>,
    /// Diameters of round blanks (mm), rising. A round blank is taken where it is smaller than the rectangular one; an
    /// empty list means none.
    pub diameters_mm: Vec<f64>,
    /// Step to which lengths, and sides beyond the list, are rounded up (mm).
    pub increment_mm: f64,
}

impl Default for Blanks {
    fn default() -> Self {
        let sides_mm = [5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0].to_vec();
        Self { sides_mm, diameters_mm: Vec::new(), increment_mm: 5.0 }
    }
}

impl Blanks {
    /// The least side that holds `length` (mm).
    pub fn side(&self, length: f64) -> f64 {
        /// Rounding of a length (mm).
        const HAIR: f64 = 1e-6;
        let known = self.sides_mm.iter().copied().find(|side| *side >= length - HAIR);
        known.unwrap_or_else(|| self.rounded_up(length))
    }

    /// The least diameter that holds `length` (mm), if there is one.
    pub fn diameter(&self, length: f64) -> Option<f64> {
        self.diameters_mm.iter().copied().find(|d| *d >= length)
    }

    /// The least multiple of the increment that holds `length` (mm).
    pub fn rounded_up(&self, length: f64) -> f64 {
        ((length / self.increment_mm) - 1e-6).ceil().max(1.0) * self.increment_mm
    }
}

/// A user's change of the division.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "change", deny_unknown_fields)]
pub enum Edit {
    /// Merges the parts at these two places: those that contain them, or the nearest whose tips do.
    Merge {
        /// Places of the mold, upright (mm).
        places: [DVec3; 2],
    },
    /// Splits the part at the middle of a line along this line.
    Split {
        /// Places of the mold at the line's ends, upright (mm).
        line: [DVec3; 2],
    },
    /// Splits the part nearest to a place along the mold's face there: the cut is this face moved by the gap and
    /// enlarged, with its draft.
    SplitAlong {
        /// A place on a steep face of the mold, upright (mm).
        place: DVec3,
    },
    /// Makes the part at a place by this method.
    Make {
        /// A place of the mold, upright (mm).
        place: DVec3,
        /// Method of making it.
        method: Method,
    },
    /// Burns the region at a place along another direction.
    Burn {
        /// A place of the mold, upright (mm).
        place: DVec3,
        /// Burn direction, upright: straight down is (0, 0, -1).
        direction: DVec3,
    },
    /// Sets the region at a place aside: no electrode is made for it.
    SetAside {
        /// A place of the mold, upright (mm).
        place: DVec3,
    },
    /// Puts the heads at these two places on one base, of whichever regions they are.
    Join {
        /// Places of the mold, upright (mm).
        places: [DVec3; 2],
    },
    /// Gives the head at a place an electrode of its own.
    TakeApart {
        /// A place of the mold, upright (mm).
        place: DVec3,
    },
    /// Burns the second place, of another cavity, with the electrode that has the head at the first one.
    Copy {
        /// Places of the mold, upright (mm).
        places: [DVec3; 2],
    },
}

impl Edit {
    /// The places that it names, upright (mm).
    pub fn places(&self) -> Vec<DVec3> {
        match self {
            Self::Merge { places } | Self::Split { line: places } | Self::Join { places } | Self::Copy { places } => {
                places.to_vec()
            }
            Self::Make { place, .. }
            | Self::Burn { place, .. }
            | Self::SetAside { place }
            | Self::SplitAlong { place }
            | Self::TakeApart { place } => {
                vec![*place]
            }
        }
    }
}

impl std::fmt::Display for Edit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Merge { places: [a, b] } => {
                write!(f, "merged at {:.2}, {:.2} and {:.2}, {:.2}", a.x, a.y, b.x, b.y)
            }
            Self::Split { line: [a, b] } => write!(f, "split from {:.2}, {:.2} to {:.2}, {:.2}", a.x, a.y, b.x, b.y),
            Self::SplitAlong { place: p } => write!(f, "split along the face at {:.2}, {:.2}, {:.2}", p.x, p.y, p.z),
            Self::Make { place, method } => {
                let how = if *method == Method::Extruding { "extruded" } else { "cut" };
                write!(f, "{how} at {:.2}, {:.2}", place.x, place.y)
            }
            Self::SetAside { place } => write!(f, "set aside at {:.2}, {:.2}", place.x, place.y),
            Self::Join { places: [a, b] } => {
                write!(f, "heads at {:.2}, {:.2} and {:.2}, {:.2} on one base", a.x, a.y, b.x, b.y)
            }
            Self::TakeApart { place } => write!(f, "head at {:.2}, {:.2} taken apart", place.x, place.y),
            Self::Copy { places: [a, b] } => {
                write!(f, "electrode at {:.2}, {:.2} copied to {:.2}, {:.2}", a.x, a.y, b.x, b.y)
            }
            Self::Burn { direction: d, .. } => write!(f, "burned along {:.2}, {:.2}, {:.2}", d.x, d.y, d.z),
        }
    }
}

/// Whether a name is one of letters, digits, `-` and `_`.
pub(super) fn is_plain(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}

/// How places of the same shape are burned that stand near one another.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Repeat {
    /// By one head, one place after another.
    #[default]
    Burns,
    /// By as many heads on one base, at once.
    Heads,
}

/// Parameters of electrodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ElectrodeParams {
    /// Stages.
    pub stages: Vec<Stage>,
    /// Shape in files.
    pub shape: Shape,
    /// Distance by which heads extend beyond the uncut region, where the mold allows it (mm).
    pub margin_mm: f64,
    /// Inner edges of heads at which regions are divided.
    pub divided_at: DividedAt,
    /// Overlap of the parts of a divided region (mm).
    pub overlap_mm: f64,
    /// Least width of a part (mm).
    pub least_size_mm: f64,
    /// Distance from the mold's top to the base (mm).
    pub extension_mm: f64,
    /// Least height of the base (mm).
    pub base_height_mm: f64,
    /// Distance by which the base extends beyond the heads (mm).
    pub base_margin_mm: f64,
    /// Chamfer at the corner of the base that shows the orientation (mm along each side).
    pub datum_corner_mm: f64,
    /// Whether congruent places share an electrode.
    pub share: bool,
    /// How congruent places are burned that stand near one another.
    pub repeat: Repeat,
    /// Greatest width of neighbouring heads on one base (mm); 0 for none.
    pub together_mm: f64,
    /// Whether electrodes of several stages for the same places stand on one base, as a family.
    pub family: bool,
    /// Least distance between the heads of a family (mm).
    pub family_spacing_mm: f64,
    /// Least retract distance after the burn (mm): each is retracted until it is clear of the mold.
    pub lift_mm: f64,
    /// Greatest retract distance that the machine allows (mm); none for any.
    pub lift_limit_mm: Option<f64>,
    /// Allowed residual stock (mm): thickness across the surface, beyond what the spark gap's radius leaves in corners.
    pub tolerance_mm: f64,
    /// Material of the electrodes.
    pub material: String,
    /// Cutters that mill the electrodes; none for those of the mold.
    pub cutters: Option<CutterLibrary>,
    /// Blanks.
    pub blanks: Blanks,
    /// Holders in the order of trying. An empty list stands for the user's library, which the reader of the parameters
    /// fills in.
    pub holders: Vec<Holder>,
    /// Technology that they burn with.
    pub technology: ProjectTechnology,
    /// Changes by the user.
    pub edits: Vec<Edit>,
    /// Overridden checks.
    pub overrides: Vec<Override>,
    /// Names given to electrodes before, which they keep.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<GivenName>,
}

impl Default for ElectrodeParams {
    fn default() -> Self {
        Self {
            stages: vec![Stage::finish(0.05)],
            shape: Shape::Undersized,
            margin_mm: 0.3,
            divided_at: DividedAt::HEdges,
            overlap_mm: 0.3,
            least_size_mm: 0.3,
            extension_mm: 5.0,
            base_height_mm: 10.0,
            base_margin_mm: 2.0,
            datum_corner_mm: 1.0,
            share: true,
            repeat: Repeat::Burns,
            together_mm: 12.0,
            family: false,
            family_spacing_mm: 5.0,
            lift_mm: 30.0,
            lift_limit_mm: None,
            tolerance_mm: 0.02,
            material: "copper".into(),
            cutters: None,
            blanks: Blanks::default(),
            holders: Vec::new(),
            technology: ProjectTechnology::default(),
            edits: Vec::new(),
            overrides: Vec::new(),
            names: Vec::new(),
        }
    }
}

/// Greatest numbers of stages and of holders.
const MOST: [(&str, usize); 2] = [("stages", 16), ("holders", 256)];

impl Validate for ElectrodeParams {
    fn validate(&self) -> Result<(), Invalid> {
        for ((key, most), count) in MOST.into_iter().zip([self.stages.len(), self.holders.len()]) {
            if count > most {
                return Err(Invalid::of(key, format!("there are {count}; at most {most} are possible")));
            }
        }
        for (key, value, range) in [
            ("margin_mm", self.margin_mm, [0.01, 20.0]),
            ("overlap_mm", self.overlap_mm, [0.0, 20.0]),
            ("least_size_mm", self.least_size_mm, [0.0, 1000.0]),
            ("extension_mm", self.extension_mm, [0.1, 1000.0]),
            ("base_height_mm", self.base_height_mm, [0.5, 1000.0]),
            ("base_margin_mm", self.base_margin_mm, [0.1, 1000.0]),
            ("datum_corner_mm", self.datum_corner_mm, [0.0, self.base_margin_mm.max(0.0)]),
            ("together_mm", self.together_mm, [0.0, 1000.0]),
            ("family_spacing_mm", self.family_spacing_mm, [0.1, 1000.0]),
            ("lift_mm", self.lift_mm, [0.0, 10000.0]),
            ("tolerance_mm", self.tolerance_mm, [1e-4, 1.0]),
        ] {
            Invalid::unless_within(key, value, range, "mm")?;
        }
        if let Some(limit) = self.lift_limit_mm {
            Invalid::unless_within("lift_limit_mm", limit, [self.lift_mm, 10000.0], "mm")?;
        }
        self.validate_stages()?;
        for (i, edit) in self.edits.iter().enumerate() {
            edit.validate().map_err(|problem| problem.within(&format!("edits[{i}]")))?;
        }
        for (i, name) in self.names.iter().enumerate() {
            name.given.validate().map_err(|problem| problem.within(&format!("names[{i}].given")))?;
        }
        let is_holder = |h: &Holder| h.size_mm.iter().chain([&h.height_mm]).all(|v| v.is_finite() && *v > 0.0);
        if let Some(bad) = self.holders.iter().find(|h| !is_holder(h)) {
            let remedy = format!("the size and height of holder {:?} must be positive", bad.name);
            return Err(Invalid::of("holders", remedy));
        }
        let rises =
            |list: &[f64]| list.iter().all(|v| v.is_finite() && *v > 0.0) && list.windows(2).all(|w| w[0] < w[1]);
        let blanks = &self.blanks;
        if !rises(&blanks.sides_mm) || !rises(&blanks.diameters_mm) || !(0.1..=100.0).contains(&blanks.increment_mm) {
            return Err(Invalid::of("blanks", "sides must rise and the increment must be from 0.1 to 100 mm"));
        }
        self.technology.validate().map_err(|problem| problem.within("technology"))?;
        let checks = CheckKind::ALL.map(CheckKind::name);
        for (i, one) in self.overrides.iter().enumerate() {
            one.validate(&checks, true).map_err(|problem| problem.within(&format!("overrides[{i}]")))?;
        }
        match &self.cutters {
            Some(library) => library.validate().map_err(|problem| problem.within("cutters")),
            None => Ok(()),
        }
    }
}

impl ElectrodeParams {
    fn validate_stages(&self) -> Result<(), Invalid> {
        let wrong = |remedy: String| Err(Invalid::of("stages", remedy));
        if self.stages.is_empty() {
            return wrong("there is no stage: give at least one burn, with its gap".to_owned());
        }
        for (i, stage) in self.stages.iter().enumerate() {
            let lengths =
                [("gap_mm", stage.gap_mm), ("stock_mm", stage.stock_mm), ("orbit.radius_mm", stage.orbit.radius_mm())];
            for (key, value) in lengths {
                Invalid::unless_within(&format!("stages[{i}].{key}"), value, [0.0, 5.0], "mm")?;
            }
            let name = &stage.name;
            if !(0.0..=60.0).contains(&stage.finish_vdi) || stage.quantity == 0 {
                return wrong(format!(
                    "stage {name}: the finish must be from VDI 0 to 60, and the quantity at least 1"
                ));
            }
            let is_known = self.stages[..i].iter().any(|s| s.name.eq_ignore_ascii_case(name));
            if is_known || !is_plain(name) {
                return wrong(format!(
                    "two stages are called {name:?}, or a name is empty or holds more than letters, digits, - and _: \
                     file names carry it"
                ));
            }
        }
        for pair in self.stages.windows(2) {
            let [earlier_mm, later_mm] = [0, 1].map(|i| pair[i].gap_mm + pair[i].stock_mm + pair[i].orbit.radius_mm());
            if later_mm > earlier_mm {
                let [earlier, later] = [0, 1].map(|i| &pair[i].name);
                return wrong(format!(
                    "stage {later} has an undersize of {later_mm} mm and follows {earlier} with {earlier_mm} mm: it \
                     would remove nothing; put the roughing stage first"
                ));
            }
        }
        Ok(())
    }
}
