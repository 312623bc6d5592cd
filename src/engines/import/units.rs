//! Units of length, and the guess which one a file is in.

use files::{Word, word};
use serde::{Deserialize, Serialize};

/// The unit of a file's coordinates, as the user gives it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Units {
    /// Guess from what the file says and from its size.
    #[default]
    Auto,
    /// Millimetres.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches of 25.4 mm.
    #[serde(alias = "in", alias = "inches")]
    Inch,
    /// Micrometres.
    Um,
}

impl Units {
    /// The words of files and of the command line, for forms.
    pub const WORDS: &[Word] = &[
        word("auto", "automatic", "As the file says, else by its size"),
        word("mm", "mm", ""),
        word("cm", "cm", ""),
        word("m", "m", ""),
        word("um", "\u{b5}m", ""),
        word("inch", "inch", ""),
    ];
}

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Millimetres.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches of 25.4 mm.
    Inch,
    /// Micrometres.
    Um,
}

impl Unit {
    /// Millimetres in one of this unit.
    pub fn in_mm(self) -> f64 {
        match self {
            Self::Mm => 1.0,
            Self::Cm => 10.0,
            Self::M => 1000.0,
            Self::Inch => 25.4,
            Self::Um => 1e-3,
        }
    }

    /// Name in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mm => "millimetres",
            Self::Cm => "centimetres",
            Self::M => "metres",
            Self::Inch => "inches",
            Self::Um => "micrometres",
        }
    }
}

impl Units {
    /// The unit, unless it is to be guessed.
    pub fn given(self) -> Option<Unit> {
        match self {
            Self::Auto => None,
            Self::Mm => Some(Unit::Mm),
            Self::Cm => Some(Unit::Cm),
            Self::M => Some(Unit::M),
            Self::Inch => Some(Unit::Inch),
            Self::Um => Some(Unit::Um),
        }
    }
}

/// Unit where neither the user nor the file names one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Undeclared {
    /// The unit is guessed from the size.
    #[default]
    Guess,
    /// Guess the unit, but refuse any guess other than millimetres: where a wrong guess would do damage.
    RefuseOthers,
    /// Take this unit, as that of the part that the file belongs to.
    Take(Unit),
}

/// The unit of a file and why it is taken.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitChoice {
    /// The unit.
    pub unit: Unit,
    /// Whether the file or the user says so, or the size leaves no other plausible unit.
    pub certain: bool,
    /// The reason, as a sentence without its full stop.
    pub reason: String,
}

/// Sizes of blisks, impellers and mold inserts (mm): the largest extent of an ordinary part.
const ORDINARY_SIZE_MM: (f64, f64) = (20.0, 1500.0);

/// Units in which parts are drawn, the usual first. Inches go before centimetres and metres because that is what
/// mechanical CAD exports, and metres before centimetres because that is what graphics programs export.
const BY_CUSTOM: [Unit; 5] = [Unit::Mm, Unit::Inch, Unit::M, Unit::Cm, Unit::Um];

/// Chooses the unit of a mesh whose largest extent is `size` in that unknown unit.
///
/// `declared` is what the file or its format says and is believed; otherwise the first of the customary units that
/// gives an ordinary part is taken.
pub fn choose(given: Option<Unit>, declared: Option<(Unit, &str)>, size: f64) -> UnitChoice {
    let in_mm = |unit: Unit| size * unit.in_mm();
    let ordinary = |unit: Unit| (ORDINARY_SIZE_MM.0..=ORDINARY_SIZE_MM.1).contains(&in_mm(unit));
    if let Some(unit) = given {
        return UnitChoice { unit, certain: true, reason: format!("{} as given", unit.name()) };
    }
    if let Some((unit, source)) = declared {
        // What is drawn for an ordinary part may be small, as electrodes are.
        let is_usual = ordinary(unit) || (unit == Unit::Mm && in_mm(unit) < ORDINARY_SIZE_MM.0);
        let doubt = if is_usual { "" } else { ", though that makes a part of unusual size" };
        let reason =
            format!("{} because {source} says so{doubt} ({} mm across)", unit.name(), significant(in_mm(unit)));
        return UnitChoice { unit, certain: is_usual, reason };
    }
    let plausible: Vec<Unit> = BY_CUSTOM.into_iter().filter(|&unit| ordinary(unit)).collect();
    let Some((&unit, others)) = plausible.split_first() else {
        let reason = format!("millimetres for want of a better guess: a size of {} fits no unit", significant(size));
        return UnitChoice { unit: Unit::Mm, certain: false, reason };
    };
    let makes = |unit: &Unit| format!("{} would make {} mm", unit.name(), significant(in_mm(*unit)));
    let mut reason = format!(
        "{} because {} of them are an ordinary size of a part, {} mm",
        unit.name(),
        significant(size),
        significant(in_mm(unit))
    );
    if !others.is_empty() {
        reason.push_str(&format!(" ({})", others.iter().map(makes).collect::<Vec<_>>().join(", ")));
    }
    // Drawings in millimetres are the custom of the trade, and a part of more than 60 "mm" can only be that or
    // centimetres, which nobody uses for parts; every other guess deserves the user's eye.
    let certain = unit == Unit::Mm && !others.contains(&Unit::Inch);
    UnitChoice { unit, certain, reason }
}

/// Chooses the unit as [`choose`] does, but with `undeclared` for a file that says none.
///
/// # Errors
/// The guess that is refused.
pub fn choose_with_care(
    given: Option<Unit>,
    declared: Option<(Unit, &str)>,
    undeclared: Undeclared,
    size: f64,
) -> Result<UnitChoice, UnitChoice> {
    let choice = choose(given, declared, size);
    if given.is_some() || declared.is_some() {
        return Ok(choice);
    }
    match undeclared {
        Undeclared::Take(unit) if unit != choice.unit => {
            let size = significant(size * unit.in_mm());
            let reason =
                format!("{} as of what it belongs to, because the file says none ({size} mm across)", unit.name());
            Ok(UnitChoice { unit, certain: false, reason })
        }
        Undeclared::RefuseOthers if choice.unit != Unit::Mm => Err(choice),
        _ => Ok(choice),
    }
}

/// The unit that a header or comment names, as in `UNITS=mm` or `# units: inches`.
pub fn declared_in(text: &str) -> Option<Unit> {
    let text = text.to_lowercase();
    let after = text.split("unit").nth(1)?;
    let word = after
        .trim_start_matches('s')
        .trim_start_matches(|c: char| c.is_whitespace() || "=:\"'(".contains(c))
        .split(|c: char| !c.is_alphabetic())
        .next()?;
    match word {
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => Some(Unit::Mm),
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => Some(Unit::Cm),
        "m" | "meter" | "meters" | "metre" | "metres" => Some(Unit::M),
        "in" | "inch" | "inches" => Some(Unit::Inch),
        "um" | "micron" | "microns" | "micrometer" | "micrometers" | "micrometre" | "micrometres" => Some(Unit::Um),
        _ => None,
    }
}

/// A length with four significant digits, for reading.
fn significant(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 12);
    format!("{x:.*}", digits as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guess(size: f64) -> (Unit, bool) {
        let choice = choose(None, None, size);
        (choice.unit, choice.certain)
    }

    #[test]
    fn sizes_of_ordinary_parts_name_their_unit() {
        assert_eq!(guess(260.0), (Unit::Mm, true));
        assert_eq!(guess(110.0), (Unit::Mm, true));
        assert_eq!(guess(40.0), (Unit::Mm, false), "40 inches would be a large blisk");
        assert_eq!(guess(10.236), (Unit::Inch, false));
        assert_eq!(guess(4.0), (Unit::Inch, false));
        assert_eq!(guess(0.26), (Unit::M, false));
        assert_eq!(guess(260_000.0), (Unit::Um, false));
        assert_eq!(guess(1e-9), (Unit::Mm, false));
    }

    #[test]
    fn a_given_unit_is_obeyed_and_a_declared_one_believed() {
        assert_eq!(choose(Some(Unit::Cm), Some((Unit::M, "glTF")), 260.0).unit, Unit::Cm);
        let declared = choose(None, Some((Unit::M, "glTF")), 0.26);
        assert_eq!((declared.unit, declared.certain), (Unit::M, true));
        let absurd = choose(None, Some((Unit::M, "glTF")), 260.0);
        assert_eq!((absurd.unit, absurd.certain), (Unit::M, false));
        let small = choose(None, Some((Unit::Mm, "the file")), 12.0);
        assert_eq!((small.unit, small.certain), (Unit::Mm, true), "an electrode");
    }

    #[test]
    fn where_a_wrong_guess_would_do_damage_none_but_millimetres_is_made() {
        let careful = |undeclared, size| choose_with_care(None, None, undeclared, size);
        for (size, guess) in [(12.0, Unit::Inch), (0.26, Unit::M), (260_000.0, Unit::Um)] {
            assert_eq!(careful(Undeclared::Guess, size).unwrap().unit, guess);
            assert_eq!(careful(Undeclared::RefuseOthers, size).unwrap_err().unit, guess);
            let taken = careful(Undeclared::Take(Unit::Mm), size).unwrap();
            assert_eq!((taken.unit, taken.certain), (Unit::Mm, false));
        }
        for undeclared in [Undeclared::RefuseOthers, Undeclared::Take(Unit::Mm)] {
            assert_eq!(careful(undeclared, 110.0), Ok(choose(None, None, 110.0)));
            let given = choose_with_care(Some(Unit::Inch), None, undeclared, 12.0);
            assert_eq!(given.unwrap().unit, Unit::Inch, "what the user says is done");
            let declared = choose_with_care(None, Some((Unit::Inch, "the file")), undeclared, 12.0);
            assert_eq!(declared.unwrap().unit, Unit::Inch, "what the file says is believed");
        }
    }

    #[test]
    fn headers_and_comments_name_units() {
        for (text, unit) in [
            ("COLOR=..., UNITS=mm  ", Some(Unit::Mm)),
            ("# File units = inches", Some(Unit::Inch)),
            ("# Units: Meters", Some(Unit::M)),
            ("unit (cm)", Some(Unit::Cm)),
            ("STL Exported by somebody", None),
            ("unity game object", None),
            ("", None),
        ] {
            assert_eq!(declared_in(text), unit, "{text}");
        }
    }

    #[test]
    fn lengths_read_well() {
        assert_eq!(significant(259.99999), "260.0");
        assert_eq!(significant(0.0123456), "0.01235");
        assert_eq!(significant(1e7), "10000000");
    }
}
