//! Compares the library's kernel, spade, delaunator and the second candidate.
//!
//! Criterion runs one after the other, so a noisy machine disturbs the comparison; `kernel-table`
//! alternates between them.

use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use lab::kernels::{Contender, Input, KINDS, Peer};

fn triangulate(c: &mut Criterion) {
    for points in [1 << 12, 1 << 16, 1 << 20] {
        let mut group = c.benchmark_group(format!("triangulate/{points}"));
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(200))
            .measurement_time(Duration::from_millis(800));
        for kind in KINDS {
            let input = Input::new(kind, points);
            group.throughput(Throughput::Elements(input.points.len() as u64));
            for peer in [Peer::Native, Peer::Spade, Peer::Delaunator, Peer::Brio] {
                let contender = &mut Contender::new(peer);
                group.bench_function(BenchmarkId::new(peer.to_string(), kind), |b| {
                    b.iter_batched(
                        || Contender::new(peer).owned(&input),
                        |owned| contender.run(&input, owned),
                        BatchSize::PerIteration,
                    );
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, triangulate);
criterion_main!(benches);
