import type { Layer } from "./state/layer";

/** Everything that the page says, in one place. */
export const TEXT = {
  title: (scene: string) => `${scene} · Flaneur`,
  stage: "Street. Drag to look, W A S D or the arrow keys to walk, Enter to go where you look.",
  toolbar: "Tools",
  chooseScene: "Scene",
  scenes: "Streets",
  scenesIntro: "This server has several. Which one would you like to walk through?",
  noScene: "This server has no scene yet. Publish one with flaneur ingest; this page will find it.",
  unknownScene: (name: string) => `There is no scene called “${name}” here.`,
  sceneSummary: (photographs: bigint, buildings: bigint, points: bigint) =>
    [
      { count: photographs, what: "photographs" },
      { count: buildings, what: "buildings" },
      { count: points, what: "points" },
    ]
      .filter(({ count }) => count > 0n)
      .map(({ count, what }) => `${count.toLocaleString("en")} ${what}`)
      .join(" · "),

  layers: "What is shown",
  layerNames: {
    hybrid: "Street",
    mesh: "Mesh",
    points: "Points",
    sources: "Sources",
    uncertainty: "Uncertainty",
    colours: "Point colours",
    wireframe: "Wireframe",
    depth: "Depth",
    normals: "Normals",
  } satisfies Record<Layer, string>,
  layerHelp: {
    hybrid: "Mesh and points, coloured by the photographs",
    mesh: "The mesh alone, coloured by the photographs",
    points: "The points alone, coloured by the photographs",
    sources: "Which photographs colour a place: each has a colour of its own",
    uncertainty: "How far the shown surface may be off",
    colours: "The points in their own colours",
    wireframe: "Mesh and points without photographs, with the edges of the mesh",
    depth: "Distance along the line of sight: white is near",
    normals: "Which way surfaces face",
  } satisfies Record<Layer, string>,
  moreLayers: "More",
  legend: {
    centimetre: "1 cm",
    decimetre: "10 cm",
    metre: "1 m",
    unseen: "no photograph",
    inferred: "inferred",
  },

  measure: "Measure",
  map: "Map",
  copyLink: "Copy a link to this view",
  linkCopied: "Link copied",
  linkElsewhere: "The link leads outside of this street. This is where it begins.",
  help: "How to move",
  close: "Close",
  zoomIn: "Zoom in",
  zoomOut: "Zoom out",

  helpRows: [
    ["Drag", "look around"],
    ["Wheel, two fingers, + and −", "zoom"],
    ["W A S D, ↑ ↓", "walk; with Shift faster"],
    ["← →, Page Up, Page Down", "turn, look up and down"],
    ["Click or tap the ground", "go there"],
    ["Click or tap a wall", "face it"],
    ["Double click, G", "go to the nearest photograph"],
    ["Enter", "act on what is in the middle"],
    ["Home", "look level"],
    ["1 to 9", "what is shown"],
    ["Tab, arrows, + −, Enter", "on the map: move, zoom, go to its middle"],
    ["M", "measure"],
    ["Esc", "leave"],
  ] as const,

  licences: "Licences of what this page is made with",

  quality: {
    connecting: "Connecting",
    loading: "Loading",
    refining: "Refining",
    final: "Final",
    fault: "Incomplete",
    resting: "Paused",
    lost: "No connection",
    full: "Server full",
    trouble: "Server trouble",
    refused: "Not available",
  },
  connectedAgain: "Connected again",
  remaining: (parts: bigint) =>
    parts === 1n ? "1 part to come" : `${parts.toLocaleString("en")} parts to come`,
  resting: "move to go on",
  retryIn: (seconds: number) => (seconds > 0 ? `trying again in ${seconds} s` : "trying again"),
  retryNow: "Try now",
  age: (seconds: number) => {
    if (seconds < 2) {
      return "just now";
    }
    if (seconds < 60) {
      return `${Math.floor(seconds)} s ago`;
    }
    return `${Math.floor(seconds / 60)} min ago`;
  },
  progress: "Loading of this view",

  insetMap:
    "Map. Click a place to go there. Arrow keys move the map, plus and minus zoom, Enter goes to its middle, Escape leaves it.",
  compass: [
    "north",
    "north-east",
    "east",
    "south-east",
    "south",
    "south-west",
    "west",
    "north-west",
  ],
  mapMiddle: (where: string, photograph: string | undefined) =>
    `In the middle of the map: ${where}${photograph === undefined ? "" : `, photograph ${photograph}`}`,
  mapZoomIn: "Zoom the map in",
  mapZoomOut: "Zoom the map out",
  mapPlain: "A plain map: this browser has no WebGL.",
  here: "You are here",

  nothingInSight: "Nothing of this street is in sight from here.",
  backToStreet: "Back to the street",

  nothingThere: "Nothing was surveyed there",
  noPhotograph: "No photograph is near",
  insideBuilding: "That is inside of a building",
  beforeBuilding: "That is inside of a building; this is the photograph nearest to it",
  pickFailed: (reason: string) => `What is there cannot be said: ${reason}`,
  noConnection: "there is no connection to the server",
  noAnswer: "the server did not answer in time",

  measurePanel: "Measure",
  measureDetails: "Details",
  measureHint: "Click a place for its coordinates, a second one for the distance.",
  measuring: "Asking the server …",
  distance: "Distance",
  horizontal: "horizontal",
  vertical: "vertical",
  place: (letter: string) => `Place ${letter}`,
  position: "Position",
  axes: "east, north, height in metres",
  heightsUnnamed: "the survey does not name what heights count from",
  localFrame: "the survey's own metres (local)",
  localFrameAt: (latitude: string, longitude: string) =>
    `metres from ${latitude}, ${longitude} (WGS84), level there (local)`,
  geographic: "WGS84",
  geographicAxes: "latitude, longitude in degrees",
  notGeographic: "not tied to the Earth",
  copy: "Copy",
  copyPosition: "Copy the position",
  copyGeographic: "Copy latitude and longitude",
  copied: "Copied",
  copyField: "To be copied",
  copyByHand:
    "This address is not encrypted (http), so the browser lets no page copy. The text is selected: copy it with Ctrl C or ⌘ C, or hold a finger on it.",
  surface: "Measured on",
  lidarPoint: (source: string) => `lidar point of source ${source}`,
  lidarExact: "Point as stored",
  gpsTime: "Measured at",
  untimed: "the survey has no times",
  days: ["Sunday", "Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday"],
  adjustedTime: (stored: string) => `adjusted standard GPS time ${stored}`,
  adjustedWithoutDate: "declared as adjusted standard GPS time, of which no date follows",
  weekDay: (day: string, time: string) => `${day} ${time} GPS time`,
  weekTime: (stored: string) =>
    `declared as GPS week time ${stored}; the survey does not say of which week, so there is no date`,
  noWeekTime: "declared as GPS week time, which it is not; no date follows",
  unknownTime: "of an older store, which does not say what it counts from: ingest the survey again",
  ground: "terrain",
  wall: (footprint: string) => `wall of building ${footprint}`,
  roof: (footprint: string) => `roof of building ${footprint}`,
  uncertainty: "Uncertainty",
  unknownUncertainty: "unknown",
  coloured: "Photograph",
  uncoloured: "none sees it",
  photographs: (count: number) =>
    count === 1 ? "1 photograph sees it" : `${count} photographs see it`,
  undated: "undated",
  clear: "Clear",

  photograph: (panorama: string, camera: string) => `Photograph ${panorama}, camera ${camera}`,
  photographLoading: "Loading the photograph",
  photographFailed: (reason: string) => `The photograph could not be loaded: ${reason}`,
  photographMissing: "The server does not know this photograph any more.",
  standThere: "Go to where it was taken",
  away: (metres: string) => `${metres} away`,

  failed: (reason: string) => `This street cannot be opened: ${reason}`,
} as const;
