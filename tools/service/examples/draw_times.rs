//! Draws map tiles without a service, one at a time, and prints the milliseconds that each takes:
//! `tools/lab/service/compare.py` sets them beside those of the service.
//!
//! ```text
//! printf 'shade 3 1 2\nmesh 4 5 6\n' | cargo run --release -p delaunay-tiles-service --example draw_times -- survey.tiles
//! ```

use std::io::BufRead;
use std::time::Instant;

use anyhow::Context;
use delaunay_tiles::map_tiles::{DrawLimits, GridKind, Layer, MapSource, TileCoord};
use delaunay_tiles::{Cache, OpenOptions, TileReader};

/// As large as the part of the service's cache that is for tiles of files.
const CACHE: usize = 192 << 20;

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let file = std::env::args_os().nth(1).context("no file is given")?;
    let options = OpenOptions::default().cache(&Cache::new(CACHE));
    let source = MapSource::open(TileReader::open(&file, options).await?).await?;
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let mut words = line.split_whitespace();
        let layer: Layer = words.next().context("no layer")?.parse()?;
        let numbers: Vec<u32> = words.map(str::parse).collect::<Result<_, _>>()?;
        let &[z, x, y] = &numbers[..] else {
            anyhow::bail!("not z x y: {line}")
        };
        let at = TileCoord::new(u8::try_from(z)?, x, y).context("there is no such tile")?;
        let began = Instant::now();
        let drawn = source.draw(GridKind::Native, layer, at, DrawLimits::default()).await?;
        println!("{} {}", began.elapsed().as_secs_f64() * 1e3, drawn.bytes.len());
    }
    Ok(())
}
