//! What queries cost, as tables and charts.

use delaunay_tiles::query::baselines::{Method, Statistics};

use super::measure::{Cost, Wanted, name};
use crate::folder::Folder;
use crate::machine;
use crate::plot::chart::{Chart, Dimension, Line};
use crate::table::{Cell, Table};
use lab::median;

/// Keeps all results.
pub fn keep(title: &str, costs: &[Cost], folder: &mut Folder) -> anyhow::Result<()> {
    folder.keep("queries.csv", all(costs).csv());
    let summary = summary(costs);
    folder.keep("summary.csv", summary.csv());
    let mut page = format!(
        "# Methods for the nearest sites among obstacles\n\n{title}. `{}` on {}. Times are medians, numbers means; all methods \
         said the same.\n\n{}\n",
        machine::command(),
        machine::describe(),
        summary.markdown()
    );
    for (file, what, value) in CHARTS {
        let chart = chart(title, what, costs, value);
        folder.keep_picture(file, chart.draw())?;
        page += &format!("![{what}]({file})\n\n");
    }
    folder.keep("README.md", page);
    Ok(())
}

type Value = fn(&Cost) -> f64;

const CHARTS: [(&str, &str, Value); 4] = [
    ("time.svg", "milliseconds, median", |cost| cost.milliseconds),
    ("edges.svg", "constraint edges considered, median", |cost| {
        cost.statistics.edges_considered as f64
    }),
    ("swept.svg", "nodes swept, median", |cost| {
        cost.statistics.nodes_swept as f64
    }),
    ("tiles.svg", "tiles read, median", |cost| cost.statistics.tiles as f64),
];

/// How a number of sites is asked for.
fn kind(wanted: Wanted) -> (&'static str, u32, Option<f64>) {
    match wanted {
        Wanted::Nearest(k) => ("k nearest", k, None),
        Wanted::Within(k, radius) => ("range", k, Some(radius)),
    }
}

fn all(costs: &[Cost]) -> Table {
    let mut table = Table::new([
        "kind",
        "k",
        "radius",
        "method",
        "place",
        "found",
        "ms",
        "candidates",
        "edges_considered",
        "edges_kept",
        "graph_nodes",
        "nodes_swept",
        "graph_edges",
        "rounds",
        "tiles",
    ]);
    for cost in costs {
        let (kind, k, radius) = kind(cost.wanted);
        let statistics = &cost.statistics;
        table.push([
            kind.into(),
            u64::from(k).into(),
            Cell::number(radius, 6),
            name(cost.method).as_str().into(),
            (cost.place as u64).into(),
            (cost.found as u64).into(),
            Cell::Number(cost.milliseconds, 3),
            statistics.candidates.into(),
            statistics.edges_considered.into(),
            statistics.edges_kept.into(),
            statistics.graph_nodes.into(),
            statistics.nodes_swept.into(),
            statistics.graph_edges.into(),
            statistics.rounds.into(),
            statistics.tiles.into(),
        ]);
    }
    table
}

/// The costs of each question and method, in the order in which they came first.
fn groups(costs: &[Cost]) -> Vec<(Wanted, Method, Vec<&Cost>)> {
    let mut groups: Vec<(Wanted, Method, Vec<&Cost>)> = Vec::new();
    for cost in costs {
        let known = groups
            .iter_mut()
            .find(|group| group.0 == cost.wanted && group.1 == cost.method);
        match known {
            Some(group) => group.2.push(cost),
            None => groups.push((cost.wanted, cost.method, vec![cost])),
        }
    }
    groups
}

fn summary(costs: &[Cost]) -> Table {
    let mut table = Table::new([
        "kind",
        "k",
        "radius",
        "method",
        "ms",
        "times the wave",
        "locate ms",
        "collect ms",
        "graph ms",
        "candidates",
        "edges considered",
        "edges kept",
        "nodes",
        "swept",
        "graph edges",
        "rounds",
        "tiles",
    ]);
    let groups = groups(costs);
    let time = |costs: &[&Cost]| median(&costs.iter().map(|cost| cost.milliseconds).collect::<Vec<_>>());
    for (wanted, method, costs) in &groups {
        let (kind, k, radius) = kind(*wanted);
        let wave = groups
            .iter()
            .find(|group| group.0 == *wanted && group.1 == Method::Wave);
        let mean = |value: fn(&Statistics) -> u64| {
            let sum: u64 = costs.iter().map(|cost| value(&cost.statistics)).sum();
            Cell::Number(sum as f64 / costs.len() as f64, 1)
        };
        let step = |name: &str| {
            let of_cost = |cost: &&Cost| {
                let step = cost.statistics.times.iter().find(|step| step.step == name);
                step.map(|step| 1e3 * step.time.as_secs_f64())
            };
            let times: Vec<f64> = costs.iter().filter_map(of_cost).collect();
            Cell::number((!times.is_empty()).then(|| median(&times)), 3)
        };
        table.push([
            kind.into(),
            u64::from(k).into(),
            Cell::number(radius, 4),
            name(*method).as_str().into(),
            Cell::Number(time(costs), 3),
            Cell::number(wave.map(|wave| time(costs) / time(&wave.2)), 1),
            step("locate"),
            step("collect"),
            step("graph"),
            mean(|statistics| statistics.candidates),
            mean(|statistics| statistics.edges_considered),
            mean(|statistics| statistics.edges_kept),
            mean(|statistics| statistics.graph_nodes),
            mean(|statistics| statistics.nodes_swept),
            mean(|statistics| statistics.graph_edges),
            mean(|statistics| statistics.rounds),
            mean(|statistics| statistics.tiles),
        ]);
    }
    table
}

/// Medians of a value against k; range queries are broken lines.
fn chart(title: &str, what: &str, costs: &[Cost], value: Value) -> Chart {
    let mut lines: Vec<Line> = Vec::new();
    let mut colours: Vec<Method> = Vec::new();
    for (wanted, method, costs) in groups(costs) {
        let (kind, k, radius) = kind(wanted);
        let line_name = format!("{}, {kind}", name(method));
        let colour = colours.iter().position(|&known| known == method).unwrap_or_else(|| {
            colours.push(method);
            colours.len() - 1
        });
        let point = (f64::from(k), median(&costs.into_iter().map(value).collect::<Vec<_>>()));
        match lines.iter_mut().find(|line| line.name == line_name) {
            Some(line) => line.points.push(point),
            None => lines.push(Line {
                name: line_name,
                colour,
                is_dashed: radius.is_some(),
                points: vec![point],
                failures: Vec::new(),
            }),
        }
    }
    Chart {
        title: "Nearest sites among obstacles".to_owned(),
        subtitle: title.to_owned(),
        x: Dimension::logarithmic("sites, k"),
        y: Dimension::logarithmic(what),
        lines,
    }
}
