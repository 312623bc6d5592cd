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

/// Invalid cutter.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CutterError {
    /// A length that no cutter has.
    #[error("cutter {cutter}: {name} is {value} mm: it must be finite and from {from} to {to} mm")]
    OutOfRange {
        /// The cutter.
        cutter: String,
        /// Name of the length.
        name: &'static str,
        /// Value of the length (mm).
        value: f64,
        /// Least that it may be (mm).
        from: f64,
        /// Most that it may be (mm).
        to: f64,
    },
    /// A rounded edge that is larger than the cutter.
    #[error(
        "cutter {cutter}: corner_mm is {corner} mm, more than the cutter's radius of {radius} mm: a bull-nose has a smaller \
         one, a ball just that; give at most {radius} mm or a larger diameter_mm"
    )]
    CornerBeyondRadius {
        /// The cutter.
        cutter: String,
        /// Radius of its rounded edge (mm).
        corner: f64,
        /// Radius of the cutter (mm).
        radius: f64,
    },
    /// Text that names no cutter.
    #[error(
        "{0:?} is no cutter; write kind:radius, or kind:radius/reach/holder radius, in mm, as in flat:1, ball:0.5/20/12 or bull:3:0.5"
    )]
    Unreadable(String),
    /// No cutter at all.
    #[error("the library holds no cutter")]
    Empty,
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

    /// Name, or the name of the shape.
    pub fn label(&self) -> String {
        if !self.name.is_empty() {
            return self.name.clone();
        }
        match self.kind() {
            CutterKind::Flat => format!("flat {}", self.diameter_mm),
            // One with too large an edge is no ball.
            CutterKind::Ball if self.corner_mm <= self.radius() => format!("ball {}", self.diameter_mm),
            _ => format!("bull-nose {} r {}", self.diameter_mm, self.corner_mm),
        }
    }

    /// Whether its lengths are those of a cutter.
    ///
    /// # Errors
    /// [`CutterError::OutOfRange`], [`CutterError::CornerBeyondRadius`].
    pub fn validate(&self) -> Result<(), CutterError> {
        let [least, most] = Self::DIAMETERS;
        let (corner, radius) = (self.corner_mm, self.radius());
        if corner > radius && corner.is_finite() && radius > 0.0 {
            return Err(CutterError::CornerBeyondRadius { cutter: self.label(), corner, radius });
        }
        let holder = self.holder_diameter_mm.unwrap_or(self.diameter_mm);
        for (name, value, from, to) in [
            ("diameter_mm", self.diameter_mm, least, most),
            ("corner_mm", self.corner_mm, 0.0, self.radius()),
            ("reach_mm", self.reach_mm.unwrap_or(least), least, 10.0 * most),
            ("holder_diameter_mm", holder, self.diameter_mm, 10.0 * most),
        ] {
            if !(from..=to).contains(&value) {
                return Err(CutterError::OutOfRange { cutter: self.label(), name, value, from, to });
            }
        }
        Ok(())
    }
}

/// `kind:radius` or `kind:radius/reach/holder radius`; a bull-nose is `bull:radius:corner`.
impl std::str::FromStr for Cutter {
    type Err = CutterError;

    fn from_str(text: &str) -> Result<Self, CutterError> {
        let unreadable = || CutterError::Unreadable(text.to_owned());
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
        cutter.holder_diameter_mm = limits.next().map(number).transpose()?.map(|radius| 2.0 * radius);
        if limits.next().is_some() {
            return Err(unreadable());
        }
        // Errors should name what was asked: a ball of a wrong radius looks like another kind.
        let named = Self { name: text.trim().to_owned(), ..cutter.clone() };
        named.validate()?;
        Ok(cutter)
    }
}

impl From<CutterError> for Invalid {
    fn from(error: CutterError) -> Self {
        match error {
            CutterError::OutOfRange { name, value, from, to, .. } => {
                Self::new(name, value, format!("must be from {from} to {to} mm"))
            }
            CutterError::CornerBeyondRadius { corner, radius, .. } => {
                let remedy = format!("must be at most the cutter's radius of {radius} mm, which makes a ball");
                Self::new("corner_mm", corner, remedy)
            }
            CutterError::Empty => Self::of("cutter", "there is no cutter; give at least one"),
            other @ CutterError::Unreadable(_) => Self::of("", other.to_string()),
        }
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
        let place = |i: usize| move |error: CutterError| Invalid::from(error).within(&format!("cutter[{i}]"));
        self.cutter.iter().enumerate().try_for_each(|(i, cutter)| cutter.validate().map_err(place(i)))?;
        Ok(Self::validate(self)?)
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
    /// Whether there is a cutter, and every one is possible.
    ///
    /// # Errors
    /// [`CutterError`].
    pub fn validate(&self) -> Result<(), CutterError> {
        if self.cutter.is_empty() {
            return Err(CutterError::Empty);
        }
        self.cutter.iter().try_for_each(Cutter::validate)
    }

    /// The cutters of which none cuts all that another one cuts: for each kind the smallest, where there is no limit of
    /// reach, and all that have one.
    pub fn needed(&self) -> Vec<&Cutter> {
        let leaves_no_more = |a: &Cutter, b: &Cutter| {
            a.reach_mm.is_none() && a.kind() == b.kind() && a.radius() <= b.radius() && a.corner_mm <= b.corner_mm
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
            assert!(matches!(read(wrong), Err(CutterError::Unreadable(_))), "{wrong}");
        }
        for wrong in ["flat:0", "ball:-1", "flat:1/-2", "bull:1:-1", "flat:5/20/1"] {
            assert!(matches!(read(wrong), Err(CutterError::OutOfRange { .. })), "{wrong}");
        }
        let said = read("bull:1:2").unwrap_err().to_string();
        assert!(said.starts_with("cutter bull:1:2: corner_mm is 2 mm") && said.contains("at most 1 mm"), "{said}");
        assert_eq!(read("bull:1:1").unwrap().kind(), CutterKind::Ball);
        assert_eq!(CutterLibrary::default().validate(), Err(CutterError::Empty));
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
