//! Colours, spacing and text sizes of the window: quiet greys, an accent, and four colours with a meaning.

use egui::style::{Selection, WidgetVisuals, Widgets};
use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, Style, TextStyle, Visuals, vec2};
use render::colour::Colour;

/// Colours with a meaning, in the present theme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Palette {
    /// Next action, selection.
    pub accent: Color32,
    /// Done, kept, certified.
    pub good: Color32,
    /// Stale, doubtful.
    pub warning: Color32,
    /// Failed, too near.
    pub bad: Color32,
    /// Text of little weight.
    pub faint: Color32,
    /// Colours of the axes X, Y, Z, A, B, C.
    pub axes: [Color32; 6],
    /// Colours of kept runs, unlike those of the axes.
    pub runs: [Color32; 6],
}

const DARK: Palette = Palette {
    accent: Color32::from_rgb(0x5b, 0x9d, 0xff),
    good: Color32::from_rgb(0x56, 0xc2, 0x86),
    warning: Color32::from_rgb(0xe6, 0xb4, 0x4c),
    bad: Color32::from_rgb(0xf0, 0x6a, 0x6a),
    faint: Color32::from_rgb(0x8d, 0x97, 0xa5),
    axes: [
        Color32::from_rgb(0xf0, 0x7a, 0x7a),
        Color32::from_rgb(0x6c, 0xc9, 0x8b),
        Color32::from_rgb(0x6f, 0xa8, 0xff),
        Color32::from_rgb(0xe9, 0xb4, 0x5c),
        Color32::from_rgb(0x5f, 0xcb, 0xd0),
        Color32::from_rgb(0xc8, 0x95, 0xe8),
    ],
    runs: [
        Color32::from_rgb(0xff, 0xff, 0xff),
        Color32::from_rgb(0xff, 0x8c, 0xc6),
        Color32::from_rgb(0xc9, 0xdb, 0x5a),
        Color32::from_rgb(0x9a, 0xa6, 0xb8),
        Color32::from_rgb(0xd0, 0x8a, 0x5e),
        Color32::from_rgb(0x8f, 0xf0, 0xd0),
    ],
};

const LIGHT: Palette = Palette {
    accent: Color32::from_rgb(0x1d, 0x63, 0xd1),
    good: Color32::from_rgb(0x1c, 0x84, 0x4b),
    warning: Color32::from_rgb(0xa0, 0x68, 0x00),
    bad: Color32::from_rgb(0xc4, 0x2b, 0x2f),
    faint: Color32::from_rgb(0x5d, 0x67, 0x74),
    axes: [
        Color32::from_rgb(0xc6, 0x37, 0x3a),
        Color32::from_rgb(0x1f, 0x88, 0x4c),
        Color32::from_rgb(0x1d, 0x63, 0xd1),
        Color32::from_rgb(0xa8, 0x6a, 0x00),
        Color32::from_rgb(0x0b, 0x7f, 0x86),
        Color32::from_rgb(0x83, 0x47, 0xb0),
    ],
    runs: [
        Color32::from_rgb(0x10, 0x14, 0x18),
        Color32::from_rgb(0xc2, 0x1f, 0x7c),
        Color32::from_rgb(0x6b, 0x7a, 0x0a),
        Color32::from_rgb(0x77, 0x82, 0x90),
        Color32::from_rgb(0x7a, 0x45, 0x1e),
        Color32::from_rgb(0x00, 0x8f, 0x6a),
    ],
};

/// The colours of the theme that `ui` is drawn in.
pub fn palette(ui: &egui::Ui) -> &'static Palette {
    if ui.visuals().dark_mode { &DARK } else { &LIGHT }
}

/// A checkbox with an edge, so that an empty one is well visible.
pub fn tick<'a>(ui: &mut egui::Ui, on: &'a mut bool, text: impl egui::IntoAtoms<'a>) -> egui::Response {
    ui.scope(|ui| {
        let edge = palette(ui).faint.gamma_multiply(0.7);
        ui.visuals_mut().widgets.inactive.bg_stroke = Stroke::new(1.0, edge);
        ui.add(egui::Checkbox::new(on, text))
    })
    .inner
}

/// Sets the style of both themes of `ctx`.
pub fn install(ctx: &egui::Context) {
    ctx.set_style_of(egui::Theme::Dark, style(true));
    ctx.set_style_of(egui::Theme::Light, style(false));
}

/// Spacing and text sizes, the same in both themes, with the theme's colours.
fn style(dark: bool) -> Style {
    let mut style = Style { visuals: visuals(dark), ..Style::default() };
    let size = |points: f32| FontId::new(points, FontFamily::Proportional);
    style.text_styles = [
        (TextStyle::Small, size(11.0)),
        (TextStyle::Body, size(13.0)),
        (TextStyle::Button, size(13.0)),
        (TextStyle::Heading, size(15.5)),
        (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
    ]
    .into();
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(6.0, 5.0);
    spacing.button_padding = vec2(8.0, 3.0);
    spacing.interact_size = vec2(36.0, 22.0);
    spacing.window_margin = Margin::same(12);
    spacing.menu_margin = Margin::same(6);
    spacing.indent = 14.0;
    spacing.slider_width = 90.0;
    spacing.combo_width = 96.0;
    spacing.tooltip_width = 320.0;
    // A bar that is there stands beside what it scrolls, and covers no values.
    spacing.scroll.floating_allocated_width = 8.0;
    style.interaction.tooltip_delay = 0.35;
    style
}

fn visuals(dark: bool) -> Visuals {
    let grey = Color32::from_gray;
    let rgb = Color32::from_rgb;
    let mut v = if dark { Visuals::dark() } else { Visuals::light() };
    let palette = if dark { DARK } else { LIGHT };
    let line = if dark { rgb(0x33, 0x39, 0x42) } else { rgb(0xd3, 0xd9, 0xe0) };
    v.panel_fill = if dark { rgb(0x1d, 0x21, 0x27) } else { rgb(0xf4, 0xf6, 0xf8) };
    v.window_fill = if dark { rgb(0x22, 0x27, 0x2e) } else { grey(0xff) };
    v.window_stroke = Stroke::new(1.0, line);
    v.extreme_bg_color = if dark { rgb(0x14, 0x17, 0x1b) } else { grey(0xff) };
    v.faint_bg_color = if dark { rgb(0x22, 0x27, 0x2d) } else { rgb(0xec, 0xef, 0xf3) };
    v.code_bg_color = v.faint_bg_color;
    v.hyperlink_color = palette.accent;
    v.warn_fg_color = palette.warning;
    v.error_fg_color = palette.bad;
    v.weak_text_color = Some(palette.faint);
    let selected = if dark { rgb(0x27, 0x46, 0x73) } else { rgb(0xc9, 0xdd, 0xf8) };
    let on_selected = if dark { grey(0xff) } else { rgb(0x0d, 0x33, 0x6e) };
    v.selection = Selection { bg_fill: selected, stroke: Stroke::new(1.0, on_selected) };
    v.window_corner_radius = CornerRadius::same(8);
    v.menu_corner_radius = CornerRadius::same(6);
    v.widgets = widgets(dark, line, palette.accent);
    v.indent_has_left_vline = false;
    v.handle_shape = egui::style::HandleShape::Rect { aspect_ratio: 0.5 };
    v.slider_trailing_fill = true;
    v
}

fn widgets(dark: bool, line: Color32, accent: Color32) -> Widgets {
    let rgb = Color32::from_rgb;
    let (text, strong) = if dark {
        (rgb(0xcf, 0xd5, 0xdd), rgb(0xf4, 0xf6, 0xf9))
    } else {
        (rgb(0x2a, 0x31, 0x3a), rgb(0x0c, 0x10, 0x15))
    };
    let look = |fill: Color32, stroke: Color32, ink: Color32| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, stroke),
        corner_radius: CornerRadius::same(4),
        fg_stroke: Stroke::new(1.0, ink),
        expansion: 0.0,
    };
    let [rest, hover, press] = if dark {
        [rgb(0x2b, 0x31, 0x39), rgb(0x36, 0x3d, 0x47), rgb(0x40, 0x49, 0x55)]
    } else {
        [rgb(0xe6, 0xea, 0xef), rgb(0xda, 0xe0, 0xe7), rgb(0xcd, 0xd5, 0xde)]
    };
    let transparent = Color32::TRANSPARENT;
    Widgets {
        noninteractive: look(transparent, line, text),
        inactive: look(rest, transparent, text),
        hovered: look(hover, line, strong),
        active: look(press, accent, strong),
        open: look(hover, line, strong),
    }
}

// Colours of bodies in the 3-D view: quiet, and distinct on dark and on light ground.

/// Metal of the blisk.
pub const STEEL: Colour = Colour::rgb(0x9d, 0xab, 0xba);
/// Electrodes.
pub const COPPER: Colour = Colour::rgb(0xd0, 0x83, 0x4f);
/// Previous positions of electrodes.
pub const GHOST: Colour = Colour::rgb(0xe0, 0xb0, 0x8a);
/// The low wall.
pub const LOW: Colour = Colour::rgb(0x6f, 0xa8, 0xa0);
/// The high wall.
pub const HIGH: Colour = Colour::rgb(0x8a, 0x96, 0xc8);
/// Bodies of a machine.
pub const MACHINE: Colour = Colour::rgb(0x7d, 0x86, 0x8c);
/// The hub of a passage.
pub const HUB: Colour = Colour::rgb(0x3f, 0xa8, 0x64);
/// The shroud of a passage, or its blade tips.
pub const SHROUD: Colour = Colour::rgb(0xa0, 0x72, 0xd2);
/// Blades.
pub const BLADE: Colour = Colour::rgb(0x4f, 0x8f, 0xe0);
/// Points of the axis.
pub const AXIS: Colour = Colour::rgb(0xd6, 0x5f, 0x9b);
/// Stations, inlet and outlet of a passage.
pub const PASSAGE: Colour = Colour::rgb(0xd9, 0x9a, 0x2b);
/// Collisions and places that are too near.
pub const BAD: Colour = Colour::rgb(0xe5, 0x48, 0x4d);

/// A colour of the scene for panels.
pub fn color32(colour: Colour) -> Color32 {
    Color32::from_rgb(colour.r, colour.g, colour.b)
}

/// Colour of mesh number `i`, from 0, among those shown together: no two of six are alike.
pub fn mesh_colour(i: usize) -> Colour {
    const OTHERS: [Colour; 6] =
        [STEEL, COPPER, LOW, HIGH, Colour::rgb(0xc9, 0xb4, 0x5a), Colour::rgb(0xb5, 0x7f, 0xa8)];
    OTHERS[i % OTHERS.len()]
}
