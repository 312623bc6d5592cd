//! Milling cutters: their shape, how far they reach, the library they stand in.

use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

/// A milling cutter with its axis along Z, the tip downwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cutter {
    /// Name in lists; empty to be called after its shape.
    #[serde(default)]
    pub name: String,
    /// Diameter of the cutting part (mm).
    pub diameter_mm: f64,
    /// Radius of the rounded edge (mm): 0 for a flat end, half the diameter for a ball, between for a bull-nose.
    #[serde(default)]
    pub corner_mm: f64,
    /// How deep it reaches below the highest material that its holder passes over (mm); none for as deep as need be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach_mm: Option<f64>,
    /// Diameter of the holder (mm); that of the cutter if there is a reach but no holder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holder_diameter_mm: Option<f64>,
}

/// Shape of the edge of a cutter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CutterKind {
    /// A cylinder with a sharp edge.
    Flat,
    /// A cylinder that ends in a half ball.
    Ball,
    /// A cylinder with a rounded edge.
    BullNose,
}

impl Cutter {
    const DIAMETERS: [f64; 2] = [0.01, 500.0];

    /// A flat-end cutter of this radius (mm) that reaches as deep as need be.
    pub fn flat(radius: f64) -> Self {
        let name = String::new();
        Self { name, diameter_mm: 2.0 * radius, corner_mm: 0.0, reach_mm: None, holder_diameter_mm: None }
    }

    /// A ball-end cutter.
    pub fn ball(radius: f64) -> Self {
        Self { corner_mm: radius, ..Self::flat(radius) }
    }

    /// A bull-nose cutter with a rounded edge of radius `corner` (mm).
    pub fn bull_nose(radius: f64, corner: f64) -> Self {
        Self { corner_mm: corner, ..Self::flat(radius) }
    }

    /// Radius of the cutting part (mm).
    pub fn radius(&self) -> f64 {
        0.5 * self.diameter_mm
    }

    /// Shape of the edge.
    pub fn kind(&self) -> CutterKind {
        if self.corner_mm <= 0.0 {
            CutterKind::Flat
        } else if self.corner_mm >= self.radius() {
            CutterKind::Ball
        } else {
            CutterKind::BullNose
        }
    }

    /// Height of its surface above its tip at a distance from its axis (mm); none beyond its radius.
    pub fn height(&self, off_axis: f64) -> Option<f64> {
        let (radius, corner) = (self.radius(), self.corner_mm);
        let beyond_flat = (off_axis - (radius - corner)).max(0.0);
        (off_axis <= radius).then(|| corner - (corner * corner - beyond_flat * beyond_flat).max(0.0).sqrt())
    }

    /// Radius of what must not pass below the material's top plus the reach (mm), and the reach; none without a limit.
    pub fn holder(&self) -> Option<(f64, f64)> {
        self.reach_mm.map(|reach| (0.5 * self.holder_diameter_mm.unwrap_or(self.diameter_mm), reach))
    }

    /// Name, or the name of the shape with its diameter, as libraries have it, and its radius, as the command line does:
    /// `flat D2 (R1)`.
    pub fn label(&self) -> String {
        if !self.name.is_empty() {
            return self.name.clone();
        }
        let size = format!("D{} (R{})", self.diameter_mm, self.radius());
        match self.kind() {
            CutterKind::Flat => format!("flat {size}"),
            // One with too large an edge is no ball.
            CutterKind::Ball if self.corner_mm <= self.radius() => format!("ball {size}"),
            _ => format!("bull-nose {size} corner R{}", self.corner_mm),
        }
    }

    /// Whether its lengths are those of a cutter.
    ///
    /// # Errors
    /// The first that is not.
    pub fn validate(&self) -> Result<(), Invalid> {
        let [least, most] = Self::DIAMETERS;
        let (corner, radius) = (self.corner_mm, self.radius());
        if corner > radius && corner.is_finite() && radius > 0.0 {
            let remedy = format!("must be at most the cutter's radius of {radius} mm, which makes a ball");
            return Err(Invalid::new("corner_mm", corner, remedy));
        }
        let holder = self.holder_diameter_mm.unwrap_or(self.diameter_mm);
        [
            ("diameter_mm", self.diameter_mm, [least, most]),
            ("corner_mm", self.corner_mm, [0.0, radius]),
            ("reach_mm", self.reach_mm.unwrap_or(least), [least, 10.0 * most]),
            ("holder_diameter_mm", holder, [self.diameter_mm, 10.0 * most]),
        ]
        .into_iter()
        .try_for_each(|(key, value, range)| Invalid::unless_within(key, value, range, "mm"))
    }
}

/// What is to be said of a decimal comma.
const COMMAS: &str = "a comma separates cutters: write decimals with a point, as in flat:0.5";

/// `kind:radius` or `kind:radius/reach/holder radius`; a bull-nose is `bull:radius:corner`.
impl std::str::FromStr for Cutter {
    type Err = Invalid;

    fn from_str(text: &str) -> Result<Self, Invalid> {
        let unreadable = || {
            let forms = "write kind:radius, or kind:radius/reach/holder radius, in mm, as in flat:1, ball:0.5/20/12 or \
                 bull:3:0.5";
            let is_number = text.trim().parse::<f64>().is_ok();
            let forms = if is_number { format!("{COMMAS}; {forms}") } else { forms.to_owned() };
            Invalid::of("", format!("{text:?} is no cutter; {forms}"))
        };
        let number = |part: &str| part.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(unreadable);
        let mut limits = text.split('/');
        let shape: Vec<&str> = limits.next().unwrap_or_default().split(':').map(str::trim).collect();
        let mut cutter = match shape[..] {
            ["flat", radius] => Self::flat(number(radius)?),
            ["ball", radius] => Self::ball(number(radius)?),
            ["bull", radius, corner] => Self::bull_nose(number(radius)?, number(corner)?),
            _ => return Err(unreadable()),
        };
        cutter.reach_mm = limits.next().map(number).transpose()?;
        let holder = limits.next().map(number).transpose()?;
        if limits.next().is_some() {
            return Err(unreadable());
        }
        // Problems are of what is written here, which is radii.
        let [least, most] = Self::DIAMETERS.map(|diameter| 0.5 * diameter);
        let radius = cutter.radius();
        Invalid::unless_within("radius", radius, [least, most], "mm").map_err(|problem| {
            let remedy = if radius == 0.0 { format!("{}; {COMMAS}", problem.remedy) } else { problem.remedy.clone() };
            Invalid { remedy, ..problem }
        })?;
        if let Some(holder) = holder {
            Invalid::unless_within("holder radius", holder, [radius, 10.0 * most], "mm")?;
        }
        cutter.holder_diameter_mm = holder.map(|radius| 2.0 * radius);
        cutter.validate()?;
        Ok(cutter)
    }
}

/// The most cutters of a library.
const MOST_CUTTERS: usize = 256;

impl Validate for CutterLibrary {
    fn validate(&self) -> Result<(), Invalid> {
        let count = self.cutter.len();
        if count > MOST_CUTTERS {
            return Err(Invalid::of(
                "cutter",
                format!("there are {count} cutters; at most {MOST_CUTTERS} are possible"),
            ));
        }
        if count == 0 {
            return Err(Invalid::of("cutter", "there is no cutter; give at least one as [[cutter]]"));
        }
        let place = |i: usize| move |problem: Invalid| problem.within(&format!("cutter[{i}]"));
        self.cutter.iter().enumerate().try_for_each(|(i, cutter)| cutter.validate().map_err(place(i)))
    }
}

/// The cutters of a shop.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CutterLibrary {
    /// The cutters, in any order.
    pub cutter: Vec<Cutter>,
}

impl CutterLibrary {
    /// The least radius of its cutters (mm); infinite without any.
    pub fn least_radius(&self) -> f64 {
        self.cutter.iter().map(Cutter::radius).fold(f64::INFINITY, f64::min)
    }

    /// The cutters of which none cuts all that another one cuts: for each kind the smallest, where there is no limit of
    /// reach, and all that have one.
    pub fn needed(&self) -> Vec<&Cutter> {
        // A larger cutter is a union of smaller ones where both its flat and its corner are larger.
        let flat = |cutter: &Cutter| cutter.radius() - cutter.corner_mm;
        let leaves_no_more = |a: &Cutter, b: &Cutter| {
            a.reach_mm.is_none() && a.kind() == b.kind() && flat(a) <= flat(b) && a.corner_mm <= b.corner_mm
        };
        let is_spare = |i: usize, cutter: &Cutter| {
            self.cutter
                .iter()
                .enumerate()
                .any(|(j, other)| j != i && leaves_no_more(other, cutter) && (!leaves_no_more(cutter, other) || j < i))
        };
        self.cutter.iter().enumerate().filter(|(i, c)| !is_spare(*i, c)).map(|(_, c)| c).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surface_of_a_cutter_is_round_where_its_corner_is() {
        let bull = Cutter::bull_nose(3.0, 1.0);
        assert_eq!(bull.height(0.0), Some(0.0));
        assert_eq!(bull.height(2.0), Some(0.0));
        assert!((bull.height(2.5).unwrap() - (1.0 - 0.75f64.sqrt())).abs() < 1e-12);
        assert_eq!((bull.height(3.0), bull.height(3.1)), (Some(1.0), None));
        assert_eq!((Cutter::flat(2.0).height(2.0), Cutter::ball(2.0).height(2.0)), (Some(0.0), Some(2.0)));
    }

    #[test]
    fn cutters_are_read_from_text_or_refused_in_words() {
        let read = |text: &str| text.parse::<Cutter>();
        assert_eq!(read("flat:1").unwrap(), Cutter::flat(1.0));
        let ball = read("ball:0.5/20/12").unwrap();
        assert_eq!((ball.kind(), ball.holder()), (CutterKind::Ball, Some((12.0, 20.0))));
        assert_eq!(read("bull:3:0.5").unwrap().kind(), CutterKind::BullNose);
        for wrong in ["", "flat", "flat:x", "cone:2", "flat:1/2/3/4", "bull:1", "flat:inf"] {
            assert!(read(wrong).unwrap_err().remedy.contains("is no cutter; write kind:radius"), "{wrong}");
        }
        // One list of cutters has commas between them, and what is written is radii.
        for part in "flat:0,5".split(',') {
            assert!(read(part).unwrap_err().to_string().contains("a comma separates cutters"), "{part}");
        }
        let said = read("flat:-1").unwrap_err().to_string();
        assert!(said.starts_with("radius is -1: must be from") && !said.contains("comma"), "{said}");
        let keys = ["radius", "radius", "reach_mm", "corner_mm", "holder radius"];
        for (wrong, key) in ["flat:0", "ball:-1", "flat:1/-2", "bull:1:-1", "flat:5/20/1"].into_iter().zip(keys) {
            assert_eq!(read(wrong).unwrap_err().key, key, "{wrong}");
        }
        let said = read("bull:1:2").unwrap_err().to_string();
        assert!(said.starts_with("corner_mm is 2: ") && said.contains("at most the cutter's radius of 1 mm"), "{said}");
        assert_eq!(read("bull:1:1").unwrap().kind(), CutterKind::Ball);
        assert!(CutterLibrary::default().validate().unwrap_err().remedy.contains("there is no cutter"));
    }

    /// The command line takes radii, libraries have diameters: a name says both.
    #[test]
    fn names_tell_radius_and_diameter_apart() {
        let label = |text: &str| text.parse::<Cutter>().unwrap().label();
        assert_eq!(["flat:1", "ball:0.35"].map(label), ["flat D2 (R1)", "ball D0.7 (R0.35)"]);
        assert_eq!(label("bull:3:0.5"), "bull-nose D6 (R3) corner R0.5");
        assert_eq!(Cutter { name: "T4".to_owned(), ..Cutter::flat(1.0) }.label(), "T4");
    }

    #[test]
    fn of_each_kind_the_smallest_does_unless_reach_is_limited() {
        let short = Cutter { reach_mm: Some(10.0), ..Cutter::flat(0.5) };
        let all = [Cutter::flat(2.0), Cutter::flat(1.0), Cutter::ball(1.0), Cutter::ball(0.5), short.clone()];
        let library = CutterLibrary { cutter: all.to_vec() };
        assert_eq!(library.needed(), [&Cutter::flat(1.0), &Cutter::ball(0.5), &short]);
        let twice = CutterLibrary { cutter: vec![Cutter::flat(1.0), Cutter::flat(1.0)] };
        assert_eq!(twice.needed().len(), 1);
        // Of two bull-noses neither may be spared where one is smaller and the other has the sharper edge.
        let bulls = CutterLibrary { cutter: vec![Cutter::bull_nose(2.0, 1.0), Cutter::bull_nose(3.0, 0.5)] };
        assert_eq!(bulls.needed().len(), 2);
    }
}
