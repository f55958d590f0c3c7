//! What can be done, and how.

/// The same as on the web page, and what a window has besides.
pub(super) const HELP: [(&str, &str); 15] = [
    ("drag", "look around"),
    ("wheel, + and -", "zoom"),
    ("W A S D, up, down", "walk; with Shift faster"),
    ("left, right, Page Up, Page Down", "turn, look up and down"),
    ("click the ground", "go there"),
    ("click a wall", "face it"),
    ("double click, G", "go to the nearest photograph"),
    ("Enter", "act on what is in the middle"),
    ("Home", "look level"),
    (
        "1 to 9",
        "street, mesh, points, sources, uncertainty,\npoint colours, wireframe, depth, normals",
    ),
    ("M", "measure: two clicks give a distance"),
    ("click a listed photograph", "see it, go to where it was taken"),
    ("O or F1", "figures"),
    ("? or H", "this help; Esc leaves"),
    ("drop a scene", "open it"),
];

/// What is said until someone does something.
pub(super) const HINT: &str = "? or H: help    O: figures    M: measure";
