//! Times of flank milling: one surface planned whole, the same with twenty times the places, the moving cutter's check.

use criterion::{Criterion, criterion_group, criterion_main};
use flank::cutter::FlankCutter;
use flank::guide::GuideCurve;
use flank::params::FlankParams;
use flank::plan::plan_flank;
use flank::ruled_surface::{RuledSurface, Side};
use glam::DVec3;
use task::Task;

fn bezier(points: [[f64; 3]; 4]) -> GuideCurve {
    GuideCurve::Bezier { points: points.map(DVec3::from).to_vec() }
}

/// P4's surface A.
fn surface() -> RuledSurface {
    let lower = bezier([[70.0, 2.0, -10.0], [81.545, 6.0, -10.0], [92.157, 0.0, -10.0], [109.3, 4.0, -10.0]]);
    let upper = bezier([[73.445, 13.857, 0.0], [81.443, 4.621, 0.0], [92.634, 2.779, 0.0], [105.48, -9.257, 0.0]]);
    RuledSurface::from_guides(&lower, &upper, Side::Positive).expect("a surface")
}

fn flank(criterion: &mut Criterion) {
    let surface = surface();
    let mut group = criterion.benchmark_group("flank");
    group.sample_size(10);
    for (name, cutter) in [("cone", FlankCutter::cone(1.0, 5.0, 40.0)), ("cylinder", FlankCutter::cylinder(2.0, 40.0))]
    {
        for (places, grid) in [("100 x 50 places", [100, 50]), ("400 x 250 places", [400, 250])] {
            let params = FlankParams { grid, ..FlankParams::default() };
            let plan = || plan_flank(&surface, &cutter, &params, &Task::default()).expect("a plan");
            group.bench_function(format!("a plan for a {name}, {places}"), |b| b.iter(plan));
        }
    }
    group.finish();
}

criterion_group!(benches, flank);
criterion_main!(benches);
