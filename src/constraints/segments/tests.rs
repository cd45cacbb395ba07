use crate::constraints::segments::spool::SegmentSpool;
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::pipeline::ingest::divide::divide;
use crate::pipeline::ingest::point_store::Item;
use crate::store::LineKind;

struct Instant(f64);
struct El(f64);
impl El {
    fn as_secs_f64(&self) -> f64 {
        self.0
    }
}
impl Instant {
    fn now() -> Self {
        Self(
            std::fs::read_to_string("/proc/thread-self/schedstat")
                .unwrap()
                .split(' ')
                .next()
                .unwrap()
                .parse::<f64>()
                .unwrap()
                / 1e9,
        )
    }
    fn elapsed(&self) -> El {
        El(Self::now().0 - self.0)
    }
}

fn place(record: u64) -> Point {
    let h = (record >> 4).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let h = h ^ h >> 29;
    let s = record.wrapping_mul(0xD6E8_FEB8_6659_FD93);
    Point::new(
        (h >> 40) as f64 + (s >> 60) as f64 * 300.0,
        (h & 0xff_ffff) as f64 + (s & 15) as f64 * 300.0,
    )
}

#[test]
#[ignore]
fn timing() {
    let env = |name: &str, or: u64| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(or);
    let (n, m, memory) = (env("N", 10_000_000), env("M", 5_000_000), env("MEM", 32 << 20));
    let near = env("NEAR", 0);
    let folder = tempfile::tempdir_in(".").unwrap();
    let mut spool = SegmentSpool::new(folder.path(), memory);
    let mut state = 1u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    let mut pushing = 0.0;
    let mut done = 0;
    while done < m {
        let pairs: Vec<[u64; 2]> = (0..8192)
            .map(|_| {
                let a = random() % n;
                [
                    a,
                    if near > 0 {
                        (a ^ (1 + random() % 15)) % n
                    } else {
                        random() % n
                    },
                ]
            })
            .collect();
        let lines: Vec<u64> = (done..done + 8192).collect();
        let began = Instant::now();
        spool.push_between(&pairs, LineKind::Wall, &lines).unwrap();
        pushing += began.elapsed().as_secs_f64();
        done += 8192;
    }
    println!("push {pushing:.3} bytes {}", spool.byte_size() >> 10);
    let mut resolving = 0.0;
    for first in (0..n).step_by(8192) {
        let records: Vec<u64> = (first..n.min(first + 8192)).collect();
        let batch = PointBatch {
            points: records.iter().map(|&r| place(r)).collect(),
            z: vec![],
            records,
        };
        let began = Instant::now();
        spool.resolve(&batch).unwrap();
        resolving += began.elapsed().as_secs_f64();
    }
    println!("resolve {resolving:.3} bytes {}", spool.byte_size() >> 10);
    let began = Instant::now();
    let mut count = 0;
    spool
        .for_each_chunk(|c| {
            count += c.len();
            Ok(())
        })
        .unwrap();
    println!(
        "read {:.3} {count} bytes {}",
        began.elapsed().as_secs_f64(),
        spool.byte_size() >> 10
    );
    let mut items: Vec<Item> = (0..65536)
        .map(|r| Item {
            point: place(r),
            position: 0,
        })
        .collect();
    let tree = divide(&mut items, 1024, 1).tree;
    let began = Instant::now();
    let blocks = spool.distribute(&tree, memory).unwrap();
    println!(
        "distribute {:.3} to {} bytes {}",
        began.elapsed().as_secs_f64(),
        tree.tiles(),
        blocks.byte_size() >> 10
    );
    let began = Instant::now();
    let mut all = 0;
    for block in 0..tree.tiles() {
        let s = blocks.take(block).unwrap();
        assert_eq!(s.len() as u64, blocks.count(block));
        all += s.len();
    }
    println!("take {:.3} {all}", began.elapsed().as_secs_f64());
    println!("peak {:?}", crate::pipeline::memory::peak_memory().map(|b| b >> 20));
}
