//! `tiletool bench read`: its output for a small file.

use crate::support::{fails, json, run};
use serde_json::Value;

#[test]
fn bench_read_compares_each_backend_with_the_device() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    run(folder, "generate uniform -n 50000 --seed 1 -o p.f64");
    run(folder, "build p.f64 -o p.tiles --tile-vertices 2000");
    let args = "bench read p.tiles --rounds 2 --backends threads,mmap";
    let json = json(folder, &format!("{args} --json"));
    assert_eq!((&json["file"], &json["rounds"]), (&"p.tiles".into(), &2.into()));
    assert!(json["all_caches_dropped"].is_boolean());
    let backends = json["backends"].as_array().unwrap();
    let names: Vec<_> = backends
        .iter()
        .map(|backend| backend["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["threads", "mmap"]);
    for backend in backends {
        for key in [
            "cold_gb_per_s",
            "cpu_seconds",
            "warm_gb_per_s",
            "warm_gb_per_cpu_second",
            "random_gb_per_s",
        ] {
            assert!(backend[key].as_f64().is_some_and(|rate| rate > 0.0), "{key}: {backend}");
        }
    }
    // Not every file system supports direct I/O. Without it, there is no comparison with the
    // device.
    match json["device"].as_object() {
        Some(device) => {
            assert_eq!(device["depths"].as_array().unwrap().len(), 6);
            let rate = |value: &Value, key: &str| value[key].as_f64().unwrap();
            let expected = rate(&backends[0], "cold_gb_per_s") / device["sequential_gb_per_s"].as_f64().unwrap();
            assert!((rate(&backends[0], "ratio_to_device") - expected).abs() < 1e-9);
        }
        None => assert!(json["note"].as_str().unwrap().contains("bypassing the page cache")),
    }
    let table = run(folder, args);
    for part in ["medians of 2 rounds", "threads", "mmap", "cores busy", "cold: "] {
        assert!(table.contains(part), "{part} is missing: {table}");
    }
}

#[test]
fn bench_read_rejects_missing_files_and_wrong_options() {
    let scratch = tempfile::tempdir().unwrap();
    assert!(fails(scratch.path(), 1, "bench read none.tiles").contains("none.tiles"));
    for args in [
        "bench read p.tiles --backends tape",
        "bench read p.tiles --rounds 0",
        "bench",
    ] {
        fails(scratch.path(), 2, args);
    }
}
