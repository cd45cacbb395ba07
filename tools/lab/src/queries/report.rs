//! The cost of queries, as tables and charts.

use delaunay_tiles::query::baselines::{Method, Statistics};

use super::measure::{Cost, RequestedSites, name};
use crate::folder::Folder;
use crate::machine;
use crate::plot::chart::{Chart, ChartLine, Dimension};
use crate::table::{Cell, Column, Table};
use lab::median;

/// Keeps all results.
pub fn keep(title: &str, costs: &[Cost], folder: &mut Folder) -> anyhow::Result<()> {
    folder.keep("queries.csv", Table::of(COLUMNS, costs).csv());
    let summary = summary(costs);
    folder.keep("summary.csv", summary.csv());
    let mut page = format!(
        "# Methods for the nearest sites among obstacles\n\n{title}. `{}` on {}. Times are medians, numbers means; all methods \
         gave the same answers.\n\n{}\n",
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

const TIME: Value = |cost| cost.milliseconds;

const CHARTS: [(&str, &str, Value); 4] = [
    ("time.svg", "milliseconds, median", TIME),
    ("edges.svg", "constraint edges considered, median", |cost| {
        cost.statistics.edges_considered as f64
    }),
    ("swept.svg", "nodes swept, median", |cost| {
        cost.statistics.nodes_swept as f64
    }),
    ("tiles.svg", "tiles read, median", |cost| cost.statistics.tiles as f64),
];

/// Returns the kind of a query, its k, and its radius.
fn kind(requested: RequestedSites) -> (&'static str, u32, Option<f64>) {
    match requested {
        RequestedSites::Nearest(k) => ("k nearest", k, None),
        RequestedSites::Within(k, radius) => ("range", k, Some(radius)),
    }
}

/// The columns of the table of all costs.
const COLUMNS: &[Column<Cost>] = &[
    ("kind", |cost| kind(cost.requested).0.into()),
    ("k", |cost| u64::from(kind(cost.requested).1).into()),
    ("radius", |cost| Cell::number(kind(cost.requested).2, 6)),
    ("method", |cost| name(cost.method).as_str().into()),
    ("query", |cost| (cost.index as u64).into()),
    ("found", |cost| (cost.found as u64).into()),
    ("ms", |cost| Cell::Number(cost.milliseconds, 3)),
    ("candidates", |cost| cost.statistics.candidates.into()),
    ("edges_considered", |cost| cost.statistics.edges_considered.into()),
    ("edges_kept", |cost| cost.statistics.edges_kept.into()),
    ("graph_nodes", |cost| cost.statistics.graph_nodes.into()),
    ("nodes_swept", |cost| cost.statistics.nodes_swept.into()),
    ("graph_edges", |cost| cost.statistics.graph_edges.into()),
    ("rounds", |cost| cost.statistics.rounds.into()),
    ("tiles", |cost| cost.statistics.tiles.into()),
];

/// The costs of one query by one method.
struct Group<'a> {
    requested: RequestedSites,
    method: Method,
    costs: Vec<&'a Cost>,
}

/// Groups the costs, in the order in which the groups first occur.
fn groups(costs: &[Cost]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group> = Vec::new();
    for cost in costs {
        let is_same_group = |group: &&mut Group| group.requested == cost.requested && group.method == cost.method;
        match groups.iter_mut().find(is_same_group) {
            Some(group) => group.costs.push(cost),
            None => groups.push(Group {
                requested: cost.requested,
                method: cost.method,
                costs: vec![cost],
            }),
        }
    }
    groups
}

impl Group<'_> {
    fn median(&self, value: Value) -> f64 {
        median(&self.costs.iter().map(|cost| value(cost)).collect::<Vec<_>>())
    }

    fn mean(&self, value: fn(&Statistics) -> u64) -> Cell {
        let sum: u64 = self.costs.iter().map(|cost| value(&cost.statistics)).sum();
        Cell::Number(sum as f64 / self.costs.len() as f64, 1)
    }

    /// Returns the median of the milliseconds that a step took, over the queries that have it.
    fn step(&self, name: &str) -> Cell {
        let of_cost = |cost: &&Cost| {
            let step = cost.statistics.times.iter().find(|step| step.step == name);
            step.map(|step| 1e3 * step.time.as_secs_f64())
        };
        let times: Vec<f64> = self.costs.iter().filter_map(of_cost).collect();
        Cell::number((!times.is_empty()).then(|| median(&times)), 3)
    }
}

/// A group, and that of the wavefront search for the same query, if there is one.
type Compared<'a> = (&'a Group<'a>, Option<&'a Group<'a>>);

fn summary(costs: &[Cost]) -> Table {
    let groups = groups(costs);
    let wavefront = |of: &Group| {
        let mut groups = groups.iter();
        groups.find(|group| group.requested == of.requested && group.method == Method::Wavefront)
    };
    let compared: Vec<Compared> = groups.iter().map(|group| (group, wavefront(group))).collect();
    let columns: [Column<Compared>; 17] = [
        ("kind", |(g, _)| kind(g.requested).0.into()),
        ("k", |(g, _)| u64::from(kind(g.requested).1).into()),
        ("radius", |(g, _)| Cell::number(kind(g.requested).2, 4)),
        ("method", |(g, _)| name(g.method).as_str().into()),
        ("ms", |(g, _)| Cell::Number(g.median(TIME), 3)),
        ("ratio to the wavefront", |(g, wavefront)| {
            Cell::number(wavefront.map(|ours| g.median(TIME) / ours.median(TIME)), 1)
        }),
        ("locate ms", |(g, _)| g.step("locate")),
        ("collect ms", |(g, _)| g.step("collect")),
        ("graph ms", |(g, _)| g.step("graph")),
        ("candidates", |(g, _)| g.mean(|its| its.candidates)),
        ("edges considered", |(g, _)| g.mean(|its| its.edges_considered)),
        ("edges kept", |(g, _)| g.mean(|its| its.edges_kept)),
        ("nodes", |(g, _)| g.mean(|its| its.graph_nodes)),
        ("swept", |(g, _)| g.mean(|its| its.nodes_swept)),
        ("graph edges", |(g, _)| g.mean(|its| its.graph_edges)),
        ("rounds", |(g, _)| g.mean(|its| its.rounds)),
        ("tiles", |(g, _)| g.mean(|its| its.tiles)),
    ];
    Table::of(&columns, &compared)
}

/// Returns a chart of the medians of a value by k; range queries are dashed lines.
fn chart(title: &str, what: &str, costs: &[Cost], value: Value) -> Chart {
    let mut lines: Vec<ChartLine> = Vec::new();
    let mut colours: Vec<Method> = Vec::new();
    for group in groups(costs) {
        let (method, (kind, k, radius)) = (group.method, kind(group.requested));
        let line_name = format!("{}, {kind}", name(method));
        let colour = colours.iter().position(|&known| known == method).unwrap_or_else(|| {
            colours.push(method);
            colours.len() - 1
        });
        let point = (f64::from(k), group.median(value));
        match lines.iter_mut().find(|line| line.name == line_name) {
            Some(line) => line.points.push(point),
            None => lines.push(ChartLine {
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
