//! The promise: a file whose inputs were distributed by tasks, in any order, more than once, killed or not,
//! has the triangles of one that was built at once.

use std::fs;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{PointBatch, SegmentBatch};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{BuildError, BuildOptions, Builder, InputPlan, InputTasks, Planned};
use distributions::Kind;

use crate::larger_than_memory::inputs::{Input, city, long_lines, valley};
use crate::larger_than_memory::tasks::{digest, finished, in_folder, options_of};
use crate::support::{Random, Scratch, points_of, runtime};

/// Cuts the batches of points into inputs.
fn cut(input: &Input, inputs: usize) -> Vec<&[PointBatch]> {
    let batches = input.points();
    batches.chunks(batches.len().div_ceil(inputs)).collect()
}

fn plan(inputs: &[&[PointBatch]]) -> InputPlan {
    let count = |batches: &&[PointBatch]| batches.iter().map(|batch| batch.len() as u64).sum();
    let points = inputs.iter().copied().flatten().flat_map(|batch| &batch.points);
    InputPlan {
        records: inputs.iter().map(count).collect(),
        has_z: inputs.iter().copied().flatten().any(|batch| !batch.z.is_empty()),
        sample: points.step_by(97).copied().collect(),
        memo: "what to do".to_owned(),
    }
}

/// Plans the tasks of inputs, of which there are several.
fn planned(inputs: &[&[PointBatch]], scratch: &Scratch, options: BuildOptions) -> InputTasks {
    let builder = Builder::new(&scratch.path, options).unwrap();
    let tasks = builder
        .plan_inputs(plan(inputs))
        .unwrap()
        .expect("they exceed the memory");
    assert_eq!((tasks.inputs() as usize, tasks.memo()), (inputs.len(), "what to do"));
    tasks
}

fn distribute(tasks: &InputTasks, input: u32, batches: &[PointBatch], memory: u64) -> Result<(), BuildError> {
    let mut task = tasks.start(input, memory)?;
    for batch in batches {
        task.push(batch)?;
    }
    let done = task.finish(&format!("input {input}"))?;
    let points: usize = batches.iter().map(PointBatch::len).sum();
    assert_eq!((done.input, done.points), (input, points as u64));
    assert!(done.bytes_written >= 17 * done.points);
    Ok(())
}

/// Distributes all inputs in a random order, some twice, some killed, some cut by power cuts. Returns a
/// builder that has taken them.
fn distributed(input: &Input, scratch: &Scratch, random: &mut Random) -> Builder {
    let inputs = cut(input, 5);
    let memory = input.options.memory;
    let is_planned = in_folder(scratch, "inputs").exists();
    drop(planned(&inputs, scratch, input.options.clone().resume(is_planned)));
    let undone =
        |tasks: &InputTasks| -> Vec<u32> { (0..tasks.inputs()).filter(|&input| !tasks.is_done(input)).collect() };
    let mut left = undone(&InputTasks::open(&scratch.path).unwrap());
    while !left.is_empty() {
        let at = random.below(left.len());
        let (number, batches) = (left[at], inputs[left[at] as usize]);
        // Each by another process.
        let tasks = InputTasks::open(&scratch.path).unwrap();
        let run = |input: u32, random: &mut Random| {
            let records = fs::read_dir(in_folder(scratch, ""))
                .unwrap()
                .map(|entry| entry.unwrap().path());
            let is_run = |path: &std::path::PathBuf| path.to_string_lossy().contains("run-");
            let mut runs: Vec<_> = records.filter(is_run).collect();
            runs.sort();
            (!runs.is_empty()).then(|| runs.swap_remove((input as usize + random.below(runs.len())) % runs.len()))
        };
        match random.below(6) {
            0 => {
                // It is killed: what it wrote has no names yet, and is removed.
                let mut task = tasks.start(number, memory).unwrap();
                task.push(&batches[0]).unwrap();
            }
            1 => {
                // Another process does the same at the same time.
                let mut other = tasks.start(number, memory).unwrap();
                batches.iter().for_each(|batch| other.push(batch).unwrap());
                distribute(&tasks, number, batches, memory).unwrap();
                other.finish(&format!("input {number}")).unwrap();
            }
            2 => {
                distribute(&tasks, number, batches, memory).unwrap();
                if let Some(run) = run(number, random) {
                    fs::File::options().write(true).open(run).unwrap().set_len(20).unwrap();
                }
            }
            _ => distribute(&tasks, number, batches, memory).unwrap(),
        }
        left = undone(&tasks);
    }
    let mut builder = Builder::new(&scratch.path, input.options.clone().resume(true)).unwrap();
    assert!(builder.needs_points() && builder.input_tasks().is_some());
    input.push_beside(&mut builder).unwrap();
    let memos = builder.take_inputs().unwrap();
    let expected: Vec<String> = (0..inputs.len()).map(|input| format!("input {input}")).collect();
    assert_eq!(memos, expected);
    input.describe(&mut builder);
    builder
}

#[test]
fn inputs_that_tasks_distributed_give_the_triangles_of_one_build() {
    let curve = Input::new("points", &points_of(Kind::Kuzmin, 100_000, 5), &[], 1_500_000);
    let mut random = Random(11);
    runtime().block_on(async {
        for input in [curve, city(), valley(), long_lines()] {
            let whole = Scratch::new();
            let at_once = input.build_at_once(&whole.path).await;
            for leaves_blocks in [false, true] {
                let scratch = Scratch::new();
                let builder = distributed(&input, &scratch, &mut random);
                let summary = match leaves_blocks {
                    false => builder.finish().await.unwrap(),
                    true => {
                        let Planned::Tasks(tasks) = builder.plan_tasks().await.unwrap() else {
                            panic!("{} has no blocks", input.name)
                        };
                        tasks.conquer(1, options_of(&input, 2)).await.unwrap();
                        drop(tasks);
                        finished(&input, &scratch.path, input.options.clone()).await.unwrap()
                    }
                };
                assert_eq!(digest(&scratch).await, digest(&whole).await, "{}", input.name);
                assert_eq!(
                    (summary.points, summary.vertices, summary.duplicates, summary.draped),
                    (at_once.points, at_once.vertices, at_once.duplicates, at_once.draped)
                );
                assert!(summary.blocks > 2, "{}", input.name);
                assert_eq!(fs::read_dir(scratch.folder.path()).unwrap().count(), 1, "work is left");
            }
        }
    });
}

/// A sample from one corner makes cells with too many points, which are split again.
#[test]
fn cells_by_a_sample_that_misleads_are_split() {
    let input = Input::new("points", &points_of(Kind::Uniform, 100_000, 6), &[], 1_500_000);
    runtime().block_on(async {
        let [whole, scratch] = [Scratch::new(), Scratch::new()];
        input.build_at_once(&whole.path).await;
        let inputs = cut(&input, 5);
        let corner = (0..400u32).map(|i| Point::new(f64::from(i % 20) / 1e4, f64::from(i / 20) / 1e4));
        let misleading = InputPlan {
            sample: corner.collect(),
            ..plan(&inputs)
        };
        let builder = Builder::new(&scratch.path, input.options.clone()).unwrap();
        let tasks = builder.plan_inputs(misleading).unwrap().unwrap();
        for (number, batches) in inputs.iter().enumerate() {
            distribute(&tasks, number as u32, batches, tasks.memory()).unwrap();
        }
        drop(tasks);
        let mut builder = Builder::new(&scratch.path, input.options.clone().resume(true)).unwrap();
        builder.take_inputs().unwrap();
        let summary = builder.finish().await.unwrap();
        let rewritten = summary.phases.iter().map(|phase| phase.bytes_written).sum::<u64>();
        assert!(rewritten > 17 * 200_000, "{summary:?}");
        assert_eq!(digest(&scratch).await, digest(&whole).await);
    });
}

/// The build that takes the inputs is stopped before it has planned blocks, and after that.
#[test]
fn a_build_that_took_inputs_can_be_stopped_and_resumed() {
    let input = city();
    let mut random = Random(5);
    runtime().block_on(async {
        let [whole, scratch] = [Scratch::new(), Scratch::new()];
        input.build_at_once(&whole.path).await;
        for _ in 0..2 {
            let mut builder = distributed(&input, &scratch, &mut random);
            let again = builder.take_inputs().unwrap_err();
            assert!(matches!(again, BuildError::Order { .. }), "{again}");
            input.describe(&mut builder);
            let Planned::Tasks(tasks) = builder.plan_tasks().await.unwrap() else {
                panic!("there are no blocks")
            };
            assert!(tasks.blocks() > 2);
            drop(tasks);
            // It was stopped before it had saved the plan, and may have split runs by then.
            fs::remove_file(in_folder(&scratch, "plan")).unwrap();
        }
        let builder = distributed(&input, &scratch, &mut random);
        builder.finish().await.unwrap();
        assert_eq!(digest(&scratch).await, digest(&whole).await);
    });
}

#[test]
fn what_input_tasks_cannot_do_is_an_error() {
    let input = Input::new("points", &points_of(Kind::Uniform, 100_000, 6), &[], 1_500_000);
    let options = || input.options.clone();
    let scratch = Scratch::new();
    runtime().block_on(async {
        let none = InputTasks::open(&scratch.path).map(|_| ()).unwrap_err();
        assert!(matches!(none, BuildError::NoTasks(_)), "{none}");
        let inputs = cut(&input, 3);
        let fresh = Builder::new(&scratch.path, options().resumable(None)).unwrap();
        let fresh = fresh.plan_inputs(plan(&inputs)).map(|_| ()).unwrap_err();
        assert!(matches!(fresh, BuildError::NotResumable), "{fresh}");
        let fits = Builder::new(&scratch.path, options().memory(64 << 20)).unwrap();
        assert!(fits.plan_inputs(plan(&inputs)).unwrap().is_none());
        let tasks = planned(&inputs, &scratch, options());
        let beyond = tasks.start(3, tasks.memory()).map(|_| ()).unwrap_err();
        assert_eq!(
            beyond.to_string(),
            "there is no input 3; the build has 3, numbered from 0"
        );
        let less = tasks.start(0, tasks.memory() - 1).map(|_| ()).unwrap_err();
        assert!(matches!(less, BuildError::TaskMemory { .. }), "{less}");
        let mut task = tasks.start(0, tasks.memory()).unwrap();
        let other = task.push(&inputs[1][0]).unwrap_err();
        let first = tasks.records(1).start;
        assert_eq!(
            other.to_string(),
            format!("input 0 has a record {first}, which it did not announce; plan the inputs again")
        );
        drop(task);
        distribute(&tasks, 1, inputs[1], tasks.memory()).unwrap();
        // Neither another build of the file, nor other options, nor what is not there yet.
        let other = Builder::new(&scratch.path, options()).unwrap_err();
        assert!(matches!(other, BuildError::WorkKept { .. }), "{other}");
        let other = Builder::new(&scratch.path, options().tile_vertices(400).resume(true)).unwrap_err();
        assert!(matches!(other, BuildError::OtherBuild { .. }), "{other}");
        let mut builder = Builder::new(&scratch.path, options().resume(true)).unwrap();
        let left = builder.take_inputs().unwrap_err();
        assert_eq!(
            left.to_string(),
            "2 of the inputs were not distributed yet, 0 is the first; do their tasks"
        );
        let between = SegmentBatch {
            records: vec![[0, 1]],
            lines: vec![0],
            ..SegmentBatch::default()
        };
        builder.push_lines(LineKind::BreakLine, 0, &between).unwrap();
        let between = builder.take_inputs().unwrap_err();
        assert!(matches!(between, BuildError::InputsForRecords), "{between}");
        drop(builder);
        // A task of an earlier plan ends after a new one was made.
        let mut late = tasks.start(0, tasks.memory()).unwrap();
        inputs[0].iter().for_each(|batch| late.push(batch).unwrap());
        let again = planned(&inputs, &scratch, options().force(true));
        let late = late.finish("").unwrap_err();
        assert!(matches!(late, BuildError::NoTasks(_)), "{late}");
        assert!((0..3).all(|input| !again.is_done(input)));
    });
}
