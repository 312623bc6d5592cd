//! Times of the planning floors on the built-in demonstration blisk.

use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use feed::clearance::{Bodies, ClearanceModel, SamplesOf};
use feed::outside::Outside;
use feed::pose::Pose;
use feed::probes::{SideDemand, Turns};
use feed::samples::{SampleSpacing, sample_electrode};
use feed::verify::Verifier;
use geometry::distance_field::DistanceField;
use geometry::exact::ExactMesh;
use glam::DVec3;
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::blisk::job::outcome::PlanInputs;
use sparkpath::workspaces::blisk::job::plan::run;
use task::{Cancel, Task};
use wheel::electrode::{EntrySide, make_electrodes};
use wheel::find_channel::find_channel;
use wheel::options::BliskOptions;
use wheel::parametric::wheel::ParametricWheel;

fn planning(criterion: &mut Criterion) {
    let task = Task::default();
    let job = PlanJob::demonstration();
    let mesh = ParametricWheel::demonstration().mesh();
    let options = BliskOptions::default();
    let mut group = criterion.benchmark_group("planning");
    group.sample_size(10);
    group.bench_function("find channel", |b| b.iter(|| find_channel(&mesh, &options, &task)));
    let channel = find_channel(&mesh, &options, &task).expect("its channel");
    let blisk = mesh.in_frame(&channel.frame);
    let exact = Arc::new(ExactMesh::new(&blisk).expect("its surface"));
    let electrodes = || make_electrodes(&channel, &exact, &job.electrode, EntrySide::PlusX, &task);
    group.bench_function("make electrode", |b| b.iter(electrodes));
    let electrode = electrodes().expect("its electrode").remove(0);
    let region = electrode.mesh.bounds().grown(8.0);
    let build = || DistanceField::build(&blisk, exact.clone(), region, 0.25, &task).expect("its field");
    // Made where it is asked for: here along the channel's walls.
    let along_walls = |field: &DistanceField| channel.low.points.iter().filter_map(|&p| field.value(p)).sum::<f64>();
    group.bench_function("distance field along a wall", |b| b.iter(|| along_walls(&build())));
    let field = build();

    // One clearance evaluation of 1,500 samples against one exact distance between the meshes.
    let body = Arc::new(ExactMesh::new(&electrode.mesh).expect("its surface"));
    let own_field =
        DistanceField::build(&electrode.mesh, body.clone(), electrode.mesh.bounds().grown(1.0), 0.35, &task)
            .expect("its field");
    let mut samples = sample_electrode(&electrode.mesh, &electrode.faces, SampleSpacing::default(), &Cancel::default())
        .expect("not cancelled");
    let stride = samples.len() / 1500;
    samples = samples.into_iter().step_by(stride.max(1)).take(1500).collect();
    let outside = Outside::new(&blisk, &electrode.mesh, electrode.reference_point);
    let bodies = Bodies {
        blisk: &field,
        electrode: &own_field,
        faces_x: channel.faces_x,
        free_radii: None,
        outside: outside.into(),
        reference_point: electrode.reference_point,
        side: electrode.enters_from,
        samples: SamplesOf::Prepared,
        sides: SideDemand::default(),
    };
    let model = ClearanceModel::new(bodies, samples, Vec::new(), &Cancel::default()).expect("no cancel");
    let pose = Pose { x: 0.2, z: 0.1, ..Pose::FINAL };
    group.bench_function("clearance of 1500 samples", |b| b.iter(|| model.least_clearance(&pose, Turns::NONE)));
    let placement = pose.placement(electrode.reference_point);
    group.bench_function("library mesh distance", |b| b.iter(|| exact.distance_to(&body, &placement)));
    let verifier =
        Verifier::new(&blisk, &electrode.mesh, electrode.reference_point, &Cancel::default()).expect("a verifier");
    group.bench_function("own mesh distance", |b| b.iter(|| verifier.distance(&pose)));
    group.bench_function("field lookup x1000", |b| {
        let points: Vec<DVec3> =
            (0..1000).map(|i| channel.low.points[i * 7 % channel.low.points.len()] + DVec3::Y * 0.3).collect();
        b.iter(|| points.iter().filter_map(|&p| field.value(p)).sum::<f64>());
    });
    let inputs = PlanInputs::of(mesh, job);
    group.bench_function("whole demonstration plan", |b| b.iter(|| run(&inputs, &task)));
    group.finish();
}

criterion_group!(benches, planning);
criterion_main!(benches);
