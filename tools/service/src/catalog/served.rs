//! A file of the catalogue, and its state at present.

use std::path::PathBuf;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, Instant};

use delaunay_tiles::store::{Cache, ReadError};
use tokio::sync::Mutex;

use super::snapshot::Snapshot;
use super::stamp::Stamp;
use crate::problem::Problem;

/// How long a state is served without a look at the file.
const CHECKED_FOR: Duration = Duration::from_millis(500);

/// A file that is served.
pub struct Served {
    /// The name in URLs.
    pub id: String,
    path: PathBuf,
    cache: Cache,
    state: RwLock<State>,
    /// Held by the one who looks at the file.
    refreshing: Mutex<()>,
}

#[derive(Clone)]
struct State {
    current: Result<Arc<Snapshot>, Problem>,
    stamp: Option<Stamp>,
    checked: Instant,
}

impl Served {
    /// Opens a file.
    ///
    /// # Errors
    /// Fails if it cannot be read.
    pub async fn open(id: String, path: PathBuf, cache: &Cache) -> Result<Self, ReadError> {
        let stamp = stamp(&path).await.ok();
        let snapshot = Snapshot::open(&path, &id, cache).await?;
        let state = State {
            current: Ok(Arc::new(snapshot)),
            stamp,
            checked: Instant::now(),
        };
        Ok(Self {
            id,
            path,
            cache: cache.clone(),
            state: RwLock::new(state),
            refreshing: Mutex::new(()),
        })
    }

    /// Returns the state of the file, which is at most half a second old if one request looks at the file
    /// at a time; others get the state before.
    ///
    /// # Errors
    /// Fails if the file is gone or damaged.
    pub async fn snapshot(&self) -> Result<Arc<Snapshot>, Problem> {
        let state = self.state();
        if state.checked.elapsed() < CHECKED_FOR {
            return state.current;
        }
        let Ok(_refreshing) = self.refreshing.try_lock() else {
            return state.current;
        };
        let now = self.look(&state).await;
        let current = now.current.clone();
        *self.state.write().unwrap_or_else(PoisonError::into_inner) = now;
        current
    }

    fn state(&self) -> State {
        self.state.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns the state after a look at the file.
    async fn look(&self, before: &State) -> State {
        let stamp = stamp(&self.path).await.ok();
        let checked = Instant::now();
        if let (Some(old), Some(new), Ok(_)) = (before.stamp, stamp, &before.current)
            && old.proves_unchanged(&new)
        {
            let current = before.current.clone();
            return State {
                current,
                stamp,
                checked,
            };
        }
        let opened = Snapshot::open(&self.path, &self.id, &self.cache).await;
        let current = match (opened, &before.current) {
            (Ok(new), Ok(old)) if self.is_same(&new, old, before.stamp, stamp) => Ok(Arc::clone(old)),
            (Ok(new), _) => {
                tracing::info!(file = self.id, version = &**new.version(), "a new state of a file");
                Ok(Arc::new(new))
            }
            (Err(error), _) => Err(Problem::of_read(&self.id, &error)),
        };
        State {
            current,
            stamp,
            checked,
        }
    }

    fn is_same(&self, new: &Snapshot, old: &Snapshot, before: Option<Stamp>, now: Option<Stamp>) -> bool {
        let is_same_file = before.zip(now).is_some_and(|(before, now)| before.is_same_file(&now));
        is_same_file && new.is_same(old)
    }
}

async fn stamp(path: &std::path::Path) -> std::io::Result<Stamp> {
    let path = path.to_owned();
    tokio::task::spawn_blocking(move || Stamp::of(&path))
        .await
        .map_err(std::io::Error::other)?
}
