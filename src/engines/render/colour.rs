//! Colours and the two themes.

/// A colour as screens understand it: sRGB, 8 bits a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Colour {
    /// Red.
    pub r: u8,
    /// Green.
    pub g: u8,
    /// Blue.
    pub b: u8,
}

impl Colour {
    /// The colour with these sRGB values.
    pub const fn rgb(r: u8, g: u8, b: u8) -> Self {
        Self { r, g, b }
    }

    /// The sRGB values as fractions of full brightness of the screen, not of light.
    pub fn to_unit(self) -> [f32; 3] {
        [self.r, self.g, self.b].map(|c| f32::from(c) / 255.0)
    }

    /// The colour with these linear-light channels; values beyond 0 to 1 are clipped.
    pub fn from_linear(linear: [f64; 3]) -> Self {
        let [r, g, b] = linear.map(|c| (encoded(c.clamp(0.0, 1.0)) * 255.0).round() as u8);
        Self { r, g, b }
    }

    /// Linear-light channels, 0 to 1.
    pub fn to_linear(self) -> [f64; 3] {
        [self.r, self.g, self.b].map(|c| decoded(f64::from(c) / 255.0))
    }
}

/// Light to screen value, IEC 61966-2-1.
fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Screen value to light, IEC 61966-2-1.
fn decoded(value: f64) -> f64 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// The colours of everything that is not an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Theme {
    /// Background at the top of the picture.
    pub background_top: Colour,
    /// Background at its bottom.
    pub background_bottom: Colour,
    /// Feature edges.
    pub edge: Colour,
    /// Lines of the ground grid.
    pub grid: Colour,
    /// Tint and edges of what is selected.
    pub accent: Colour,
    /// Outline of a section's cut faces.
    pub section: Colour,
}

impl Theme {
    /// For work in a dim room.
    pub const DARK: Self = Self {
        background_top: Colour::rgb(0x2b, 0x30, 0x38),
        background_bottom: Colour::rgb(0x15, 0x18, 0x1d),
        edge: Colour::rgb(0x0b, 0x0d, 0x10),
        grid: Colour::rgb(0x7b, 0x86, 0x96),
        accent: Colour::rgb(0xff, 0xa0, 0x2e),
        section: Colour::rgb(0xf2, 0xf4, 0xf7),
    };

    /// For bright rooms and for paper.
    pub const LIGHT: Self = Self {
        background_top: Colour::rgb(0xfb, 0xfc, 0xfd),
        background_bottom: Colour::rgb(0xdd, 0xe2, 0xe9),
        edge: Colour::rgb(0x23, 0x2a, 0x33),
        grid: Colour::rgb(0x6a, 0x76, 0x86),
        accent: Colour::rgb(0xe0, 0x7a, 0x00),
        section: Colour::rgb(0x16, 0x1b, 0x22),
    };
}

impl Default for Theme {
    fn default() -> Self {
        Self::DARK
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_and_screen_values_are_inverse_and_meet_the_standard() {
        for v in 0..=255 {
            let colour = Colour::rgb(v, 255 - v, v / 2);
            assert_eq!(Colour::from_linear(colour.to_linear()), colour);
        }
        // Half the light is 188 on the screen.
        assert_eq!(Colour::from_linear([0.5; 3]), Colour::rgb(188, 188, 188));
    }
}
