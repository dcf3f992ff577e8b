//! Files are dragged over the window and dropped on it by another program, which speaks XDND as file managers do.

use crate::{Screen, wait};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConnectionExt, CreateWindowAux, EventMask, PropMode, SelectionNotifyEvent, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

x11rb::atom_manager! {
    Atoms: AtomsCookie {
        XdndAware,
        XdndProxy,
        XdndEnter,
        XdndPosition,
        XdndStatus,
        XdndLeave,
        XdndDrop,
        XdndFinished,
        XdndSelection,
        XdndActionCopy,
        TEXT_URI_LIST: b"text/uri-list",
    }
}

/// The program that files are dragged from.
struct Source {
    connection: RustConnection,
    atoms: Atoms,
    own: u32,
    /// The window of Illuminator, and where its messages go.
    target: u32,
    proxy: u32,
    list: String,
}

impl Source {
    fn new(screen: &Screen, list: String) -> Self {
        let (connection, number) = RustConnection::connect(Some(&screen.display)).expect("a connection");
        let atoms = Atoms::new(&connection).expect("a request").reply().expect("names");
        let root = connection.setup().roots[number].root;
        let own = connection.generate_id().expect("a number");
        let class = WindowClass::INPUT_ONLY;
        connection.create_window(0, own, root, 0, 0, 1, 1, 0, class, 0, &CreateWindowAux::new()).expect("a window");
        let target = screen.window_id().expect("a window").parse().expect("a number");
        let property = |window: u32, name: u32| {
            let reply = connection.get_property(false, window, name, AtomEnum::ANY, 0, 1).expect("a request").reply();
            reply.expect("an answer").value32().and_then(|mut values| values.next())
        };
        // As GTK and Qt look for it: the proxy must name itself.
        let proxy = property(target, atoms.XdndProxy).expect("a proxy");
        assert_eq!(property(proxy, atoms.XdndProxy), Some(proxy));
        assert_eq!([property(target, atoms.XdndAware), property(proxy, atoms.XdndAware)], [Some(5); 2]);
        connection.set_selection_owner(own, atoms.XdndSelection, x11rb::CURRENT_TIME).expect("a request");
        Self { connection, atoms, own, target, proxy, list }
    }

    fn send(&self, kind: u32, rest: [u32; 4]) {
        let [one, two, three, four] = rest;
        let message = ClientMessageEvent::new(32, self.target, kind, [self.own, one, two, three, four]);
        self.connection.send_event(false, self.proxy, EventMask::NO_EVENT, message).expect("a request");
        self.connection.flush().expect("a connection");
    }

    /// Gives the names of the files to whoever asks, until a message of this kind comes.
    fn answer(&self, kind: u32) -> [u32; 5] {
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(30) {
            #[allow(clippy::wildcard_enum_match_arm, reason = "other events are none of this test's")]
            match self.connection.poll_for_event().expect("a connection") {
                Some(Event::SelectionRequest(asked)) => {
                    assert_eq!(asked.target, self.atoms.TEXT_URI_LIST);
                    let (mode, list) = (PropMode::REPLACE, self.list.as_bytes());
                    self.connection.change_property8(mode, asked.requestor, asked.property, asked.target, list).expect("it");
                    let SelectionNotifyEvent { response_type, sequence, .. } = SelectionNotifyEvent::default();
                    let told = SelectionNotifyEvent {
                        response_type: response_type | x11rb::protocol::xproto::SELECTION_NOTIFY_EVENT,
                        sequence,
                        time: asked.time,
                        requestor: asked.requestor,
                        selection: asked.selection,
                        target: asked.target,
                        property: asked.property,
                    };
                    self.connection.send_event(false, asked.requestor, EventMask::NO_EVENT, told).expect("a request");
                    self.connection.flush().expect("a connection");
                }
                Some(Event::ClientMessage(message)) if message.type_ == kind => return message.data.as_data32(),
                Some(_) => {}
                None => std::thread::sleep(Duration::from_millis(5)),
            }
        }
        panic!("no answer came");
    }

    /// Comes over the window with something of this type, at a place of the screen. Whether it is welcome.
    fn enter(&self, kind: u32, [x, y]: [i32; 2]) -> bool {
        self.send(self.atoms.XdndEnter, [5 << 24, kind, 0, 0]);
        self.send(self.atoms.XdndPosition, [0, (x as u32) << 16 | y as u32, 0, self.atoms.XdndActionCopy]);
        let [target, flags, ..] = self.answer(self.atoms.XdndStatus);
        assert_eq!(target, self.target);
        flags & 1 == 1
    }
}

#[test]
fn files_from_another_program_are_announced_and_opened() {
    let screen = Screen::new("preset:studio");
    screen.picture_at_rest();
    let [scene, mesh] = ["my room.scene", "wedge.obj"].map(|name| screen.home.path().join(name));
    let text = "bodies; floor: rectangle, <-8, 0, -8>, <8, 0, -8>, <8, 0, 8>; lights; key: point, <3, 4, 9>;\n\
                camera; position <0, 2, 9>; gaze <0, -0.2, -1>; up <0, 1, 0>; fov 45;";
    std::fs::write(&scene, text).expect("a file");
    std::fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").expect("a file");
    let uri = |path: &std::path::Path| format!("file://{}\r\n", path.display().to_string().replace(' ', "%20"));
    let source = Source::new(&screen, format!("# from a test\r\n{}{}", uri(&mesh), uri(&scene)));
    let middle = { screen.corner().map(|side| side + 390) };
    assert!(!source.enter(u32::from(AtomEnum::STRING), middle), "a text is no file");
    source.send(source.atoms.XdndLeave, [0; 4]);
    let before = screen.pixels([500, 300], [300, 100]);
    assert!(source.enter(source.atoms.TEXT_URI_LIST, middle));
    // The names of the files are asked for meanwhile.
    source.send(source.atoms.XdndPosition, [0, 0, 0, source.atoms.XdndActionCopy]);
    source.answer(source.atoms.XdndStatus);
    wait("what a drop would do", || screen.pixels([500, 300], [300, 100]) != before);
    source.send(source.atoms.XdndLeave, [0; 4]);
    wait("the picture without it", || screen.pixels([500, 300], [300, 100]) == before);
    assert!(source.enter(source.atoms.TEXT_URI_LIST, middle));
    source.send(source.atoms.XdndDrop, [0; 4]);
    assert_eq!(source.answer(source.atoms.XdndFinished)[..3], [source.target, 1, source.atoms.XdndActionCopy]);
    wait("the scene", || screen.told("my room.scene: read in") == 1);
    wait("the mesh", || screen.told("wedge: added from") == 1);
    assert!(screen.window_id().is_some(), "the window is still there");
}
