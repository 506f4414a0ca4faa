//! An image viewer on the network that is shown a render while it grows (`--display-server`).
//!
//! A thread of its own connects and sends; whoever hands it a picture never waits. It sends the latest
//! picture and leaves out what came in between, so a slow viewer sees fewer pictures, and an absent or
//! lost one is told once and costs the render nothing.

use snowgrain_film::Picture;
use snowgrain_formats::tev;
use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How long a viewer may take to answer, and to take some of a picture.
const PATIENCE: Duration = Duration::from_secs(5);
/// How long the end of a render waits for the last picture to be taken.
const FAREWELL: Duration = Duration::from_secs(2);

/// A viewer that pictures are sent to.
pub(crate) struct Viewer {
    address: String,
    post: Arc<Post>,
}

/// Between those who have pictures and the thread that sends them.
#[derive(Default)]
struct Post {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// The picture to be sent next.
    picture: Option<Picture>,
    /// No more pictures come.
    ended: bool,
    /// The thread sends no more.
    gone: bool,
    /// Why, until it is told.
    fault: Option<String>,
}

impl Viewer {
    /// Starts to look for a viewer at `address` (`host:port`), which is to call the picture `name`.
    pub(crate) fn at(address: &str, name: String) -> Self {
        let post = Arc::new(Post::default());
        let (sender, to) = (Arc::clone(&post), address.to_owned());
        // Not joined: a connection that hangs must not hold the program.
        std::thread::spawn(move || {
            let sent = send_all(&sender, &to, &name);
            let mut state = sender.lock();
            state.gone = true;
            state.fault = sent.err().map(|error| error.to_string());
            sender.changed.notify_all();
        });
        Self { address: address.to_owned(), post }
    }

    /// Whether it may still take pictures.
    pub(crate) fn is_there(&self) -> bool {
        !self.post.lock().gone
    }

    /// Hands over a picture, in place of one that still waits.
    pub(crate) fn show(&self, picture: Picture) {
        self.post.lock().picture = Some(picture);
        self.post.changed.notify_all();
    }

    /// Says that no more pictures come, and waits a little for the last one to be taken.
    pub(crate) fn finish(&self) {
        let mut state = self.post.lock();
        state.ended = true;
        self.post.changed.notify_all();
        let waiting = self.post.changed.wait_timeout_while(state, FAREWELL, |state| !state.gone);
        let (mut state, _) = waiting.unwrap_or_else(PoisonError::into_inner);
        if !state.gone {
            state.fault = Some("it does not take the last picture".into());
        }
    }

    /// What is to be told of its loss, once.
    pub(crate) fn fault(&self) -> Option<String> {
        let fault = self.post.lock().fault.take()?;
        Some(format!(
            "the viewer at {} is not shown the picture ({fault}); the render does not depend on it",
            self.address
        ))
    }
}

impl Post {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a picture; `None` where no more come.
    fn next(&self) -> Option<Picture> {
        let idle = |state: &mut State| state.picture.is_none() && !state.ended;
        let waiting = self.changed.wait_while(self.lock(), idle);
        waiting.unwrap_or_else(PoisonError::into_inner).picture.take()
    }
}

/// Connects and sends pictures until no more come.
fn send_all(post: &Post, address: &str, name: &str) -> io::Result<()> {
    let mut viewer = connect(address)?;
    let mut shown = false;
    while let Some(picture) = post.next() {
        if !shown {
            viewer.write_all(&tev::create_image(name, picture.width(), picture.height()))?;
            shown = true;
        }
        for packet in tev::update_image(name, &picture).into_iter().flatten() {
            viewer.write_all(&packet)?;
        }
    }
    viewer.flush()
}

/// Tries every address that the name has.
fn connect(address: &str) -> io::Result<TcpStream> {
    let mut fault = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(viewer) => {
                viewer.set_write_timeout(Some(PATIENCE))?;
                return Ok(viewer);
            }
            Err(error) => fault = error,
        }
    }
    Err(fault)
}
