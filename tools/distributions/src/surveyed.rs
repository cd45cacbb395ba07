//! Points as instruments and maps deliver them: along lines, in the order of acquisition, rounded.

use crate::random::{Purpose, Stream, cos_sin, sin};
use crate::source::Source;

/// Rounds to a multiple of 0.01 as LAS stores it: an integer, times the scale, plus an offset.
fn hundredths(x: f64, offset: f64) -> f64 {
    (x * 100.0).round() * 0.01 + offset
}

/// [`Kind::Lidar`](crate::Kind::Lidar).
///
/// ```text
///   strip 0   strip 1        one strip, seen from above; flight is upwards, then
///   /\/\/|  /\/\/|             downwards in the next strip
///   \/\/\|  \/\/\|                 4 <- 3 <- 2 <- 1
///   /\/\/|  /\/\/|           0 -> 1 -> 2 -> 3 -> 0'      points 0.5, lines 0.7 apart
/// ```
#[derive(Clone, Debug)]
pub(crate) struct Lidar {
    stream: Stream,
    heights: Stream,
    phases: [f64; 3],
    /// The distance between the middles of two strips, and the length of a strip.
    pitch: f64,
    length: f64,
    /// The number of points of a scan line, and of scan lines of a strip.
    per_line: u64,
    lines: u64,
    strip: u64,
    line: u64,
    position: u64,
}

impl Lidar {
    const EAST: f64 = 600_000.0;
    const NORTH: f64 = 4_900_000.0;
    const LINE_SPACING: f64 = 0.7;
    const POINT_SPACING: f64 = 0.5;
    /// The ratio of a strip's width to the pitch of strips.
    const OVERLAP: f64 = 1.2;

    pub(crate) fn new(n: u64, seed: u64) -> Self {
        let length = (n as f64 * (Self::LINE_SPACING * Self::POINT_SPACING / Self::OVERLAP)).sqrt();
        let strips = (length / 600.0).ceil().max(1.0);
        let pitch = length / strips;
        let mut heights = Stream::new(seed, Purpose::Heights);
        Lidar {
            stream: Stream::new(seed, Purpose::Points),
            phases: [heights.unit(), heights.unit(), heights.unit()],
            heights,
            pitch,
            length,
            per_line: (pitch * Self::OVERLAP / Self::POINT_SPACING).ceil().max(1.0) as u64,
            lines: (length / Self::LINE_SPACING).ceil().max(1.0) as u64,
            strip: 0,
            line: 0,
            position: 0,
        }
    }

    /// Returns the height of the terrain and the noise of one measurement at a point of
    /// [`Source::next`].
    pub(crate) fn height(&mut self, x: f64, y: f64) -> f64 {
        let (x, y) = (x - Self::EAST, y - Self::NORTH);
        let hills = 40.0 * sin(x / 5600.0 + self.phases[0] + 0.05 * sin(y / 4400.0));
        let slopes = 12.0 * sin(y / 1950.0 - x / 3100.0 + self.phases[1]);
        let bumps = 1.5 * sin((x + y) / 360.0 + self.phases[2]) * sin((x - y) / 290.0);
        hundredths(300.0 + hills + slopes + bumps + 0.05 * self.heights.noise(), 0.0)
    }
}

impl Source for Lidar {
    fn next(&mut self) -> [f64; 2] {
        let along = self.position as f64 / self.per_line as f64;
        let across = if self.line.is_multiple_of(2) {
            along
        } else {
            1.0 - along
        };
        let flown = (self.line as f64 + along) * Self::LINE_SPACING;
        let x = (self.strip as f64 + across * Self::OVERLAP) * self.pitch + 0.1 * self.stream.noise();
        let y = if self.strip.is_multiple_of(2) {
            flown
        } else {
            self.length - flown
        } + 0.1 * self.stream.noise();

        self.position += 1;
        if self.position == self.per_line {
            (self.position, self.line) = (0, self.line + 1);
        }
        if self.line == self.lines {
            (self.line, self.strip) = (0, self.strip + 1);
        }
        [hundredths(x, Self::EAST), hundredths(y, Self::NORTH)]
    }
}

/// [`Kind::Contours`](crate::Kind::Contours).
///
/// Line j is y = 40 j + g(x, j), where g is a sum of two sines. |∂g/∂j| < 11 < 40, so lines do not
/// meet.
#[derive(Clone, Debug)]
pub(crate) struct Contours {
    phases: [f64; 2],
    width: f64,
    line: f64,
    x: f64,
}

impl Contours {
    const SPACING: f64 = 40.0;

    pub(crate) fn new(n: u64, seed: u64) -> Self {
        let mut stream = Stream::new(seed, Purpose::Points);
        // A square: the lines that fit in the height have n units of length together.
        let width = (n as f64 * Self::SPACING).sqrt().max(1.0);
        Contours {
            phases: [stream.unit(), stream.unit()],
            width,
            line: 0.0,
            x: 0.0,
        }
    }
}

impl Source for Contours {
    fn next(&mut self) -> [f64; 2] {
        const WAVES: [f64; 2] = [500.0, 60.0];
        const AMPLITUDES: [f64; 2] = [25.0, 4.0];
        const DRIFTS: [f64; 2] = [0.05, 0.11];
        let (x, mut y, mut slope) = (self.x, self.line * Self::SPACING, 0.0);
        for i in 0..2 {
            let [cos, sin] = cos_sin(x / WAVES[i] + DRIFTS[i] * self.line + self.phases[i]);
            y += AMPLITUDES[i] * sin;
            slope += AMPLITUDES[i] * cos * (std::f64::consts::TAU / WAVES[i]);
        }
        self.x += 1.0 / (1.0 + slope * slope).sqrt();
        if self.x > self.width {
            (self.x, self.line) = (0.0, self.line + 1.0);
        }
        [hundredths(x, 0.0), hundredths(y, 0.0)]
    }
}

/// [`Kind::Streets`](crate::Kind::Streets).
#[derive(Clone, Debug)]
pub(crate) struct Streets {
    stream: Stream,
    /// The number of blocks along a street.
    blocks: u64,
    street: u64,
    block: u64,
    /// The number of vertices of this block, including its first crossing, and the number of
    /// vertices returned.
    vertices: u64,
    vertex: u64,
}

impl Streets {
    const BLOCK: f64 = 100.0;
    /// The average number of vertices per block.
    const VERTICES: f64 = 10.0;

    pub(crate) fn new(n: u64, seed: u64) -> Self {
        // b blocks by b blocks have 2 (b + 1) streets of b blocks.
        let blocks = (n as f64 / (2.0 * Self::VERTICES)).sqrt().ceil().max(1.0) as u64;
        Streets {
            stream: Stream::new(seed, Purpose::Points),
            blocks,
            street: 0,
            block: 0,
            vertices: 0,
            vertex: 0,
        }
    }
}

impl Source for Streets {
    fn next(&mut self) -> [f64; 2] {
        if self.vertex == self.vertices {
            if self.vertices > 0 {
                self.block += 1;
            }
            if self.block > self.blocks {
                (self.block, self.street) = (0, self.street + 1);
            }
            // Nothing follows the last crossing of a street.
            self.vertices = if self.block == self.blocks {
                1
            } else {
                5 + self.stream.below(11)
            };
            self.vertex = 0;
        }
        let mut within = 0.0;
        if self.vertex > 0 {
            within = (self.vertex as f64 + 0.8 * self.stream.unit() - 0.4) / self.vertices as f64;
        }
        self.vertex += 1;
        let along = (self.block as f64 + within) * Self::BLOCK;
        let across = (self.street / 2) as f64 * Self::BLOCK;
        let [x, y] = if self.street.is_multiple_of(2) {
            [along, across]
        } else {
            [across, along]
        };
        [hundredths(0.8 * x - 0.6 * y, 0.0), hundredths(0.6 * x + 0.8 * y, 0.0)]
    }
}

/// [`Kind::Tracks`](crate::Kind::Tracks).
#[derive(Clone, Debug)]
pub(crate) struct Tracks {
    stream: Stream,
    /// Metres from the middle of the region, angle in turns, metres per second.
    at: [f64; 2],
    heading: f64,
    speed: f64,
    /// The seconds left of the track, and of a pause in it.
    seconds: u64,
    pause: u64,
}

impl Tracks {
    /// Half the width of the region in metres.
    const REACH: f64 = 35_000.0;

    pub(crate) fn new(seed: u64) -> Self {
        let stream = Stream::new(seed, Purpose::Points);
        Tracks {
            stream,
            at: [0.0; 2],
            heading: 0.0,
            speed: 0.0,
            seconds: 0,
            pause: 0,
        }
    }

    fn step(&mut self) {
        if self.seconds == 0 {
            self.seconds = 200 + self.stream.below(3000);
            self.at = [self.stream.unit(), self.stream.unit()].map(|u| (2.0 * u - 1.0) * Self::REACH);
            self.heading = self.stream.unit();
        }
        self.seconds -= 1;
        if self.pause > 0 {
            self.pause -= 1;
            return;
        }
        if self.stream.below(300) == 0 {
            self.pause = 10 + self.stream.below(60);
        }
        if self.at.iter().any(|x| x.abs() > Self::REACH) {
            // Heads roughly back: towards the middle, from the side on which it left.
            let quarter = if self.at[0].abs() > self.at[1].abs() { 0.0 } else { 0.25 };
            let coordinate = if quarter == 0.0 { self.at[0] } else { self.at[1] };
            self.heading = quarter + if coordinate > 0.0 { 0.5 } else { 0.0 };
        }
        self.heading += 0.02 * self.stream.noise();
        self.speed = (self.speed + self.stream.noise()).clamp(0.0, 20.0);
        let [cos, sin] = cos_sin(self.heading);
        self.at = [self.at[0] + self.speed * cos, self.at[1] + self.speed * sin];
    }
}

impl Source for Tracks {
    fn next(&mut self) -> [f64; 2] {
        // Metres per degree of longitude at 47.5° north, and of latitude.
        const METRES: [f64; 2] = [75_300.0, 111_200.0];
        const MIDDLE: [f64; 2] = [8.5, 47.5];
        self.step();
        std::array::from_fn(|i| {
            let metres = self.at[i] + 1.5 * self.stream.noise();
            ((MIDDLE[i] + metres / METRES[i]) * 1e6).round() / 1e6
        })
    }
}
