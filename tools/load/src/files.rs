//! The files that are served, and their changes.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use tempfile::TempDir;
use tokio::process::Command;
use tokio::time::sleep;

/// The time between two changes.
const PAUSE: Duration = Duration::from_secs(1);

/// A folder with files to serve: `town` changes, `survey` does not.
pub struct Files {
    folder: TempDir,
    tiletool: PathBuf,
}

impl Files {
    /// Builds the files.
    pub async fn new(tiletool: &Path) -> anyhow::Result<Self> {
        let this = Self {
            folder: tempfile::tempdir()?,
            tiletool: std::path::absolute(tiletool)?,
        };
        this.houses()?;
        for wall in ["wall", "fence"] {
            let x = if wall == "wall" { 0.5267 } else { 0.26 };
            std::fs::write(this.path(&format!("{wall}.csv")), format!("{x},0.1,{x},0.9\n"))?;
        }
        for (seed, name) in [(1, "first"), (2, "second")] {
            this.run(&format!("generate uniform -n 20000 --seed {seed} -o {name}.f64"))
                .await?;
            let build = format!("build {name}.f64 --obstacles houses.geojson -o {name}.tiles --tile-vertices 1000");
            this.run(&build).await?;
        }
        this.run("generate lidar -n 100000 --dims 3 --seed 7 -o survey.f64")
            .await?;
        this.run("build survey.f64 --dims 3 --crs EPSG:25832 --tile-vertices 2000 -o survey.tiles")
            .await?;
        std::fs::copy(this.path("first.tiles"), this.path("town.tiles"))?;
        Ok(this)
    }

    /// Writes a grid of houses.
    fn houses(&self) -> std::io::Result<()> {
        let house = |i: u32| {
            let [x, y] = [i % 15, i / 15].map(|at| f64::from(at) / 15.0 + 0.013);
            let [u, v] = [x + 0.04, y + 0.03];
            format!("[[[{x},{y}],[{u},{y}],[{u},{v}],[{x},{v}],[{x},{y}]]]")
        };
        let houses: Vec<String> = (0..225).map(house).collect();
        let text = format!("{{\"type\":\"MultiPolygon\",\"coordinates\":[{}]}}", houses.join(","));
        std::fs::write(self.path("houses.geojson"), text)
    }

    /// Returns the path of a file.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    async fn run(&self, args: &str) -> anyhow::Result<()> {
        let mut command = Command::new(&self.tiletool);
        command.args(args.split(' ')).current_dir(self.folder.path());
        let done = command.stdout(Stdio::null()).stderr(Stdio::null()).status().await;
        let status = done.with_context(|| format!("cannot run {}", self.tiletool.display()))?;
        ensure!(status.success(), "tiletool {args}: {status}");
        Ok(())
    }

    /// Edits and replaces the town until `end`. Returns how often.
    pub async fn change(&self, end: Instant) -> anyhow::Result<u64> {
        let mut changes = 0;
        while Instant::now() < end {
            let next = ["second", "first"][(changes / 4 % 2) as usize];
            match changes % 4 {
                0 => self.run("constrain town.tiles --walls wall.csv").await?,
                1 => self.run("overviews town.tiles").await?,
                2 => self.run("constrain town.tiles --walls fence.csv").await?,
                _ => {
                    std::fs::copy(self.path(&format!("{next}.tiles")), self.path("new.tiles"))?;
                    std::fs::rename(self.path("new.tiles"), self.path("town.tiles"))?;
                }
            }
            changes += 1;
            sleep(PAUSE).await;
        }
        Ok(changes)
    }
}
