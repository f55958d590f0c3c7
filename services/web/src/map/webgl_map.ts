import type { Feature, FeatureCollection } from "geojson";
import maplibre from "maplibre-gl";
import "maplibre-gl/dist/maplibre-gl.css";
import { element, svg } from "../dom";
import { degrees, radians } from "../geometry/angles";
import { TEXT } from "../strings";
import type { Pose } from "../view/pose";
import type { Outline } from "./buildings";
import type { Earth, LngLat } from "./earth";
import { conePath, type InsetMap, type InsetMapEvents, NEAR_PX, type Spot } from "./inset";

const FIRST_ZOOM = 17.5;
/** The map goes along once one is so near to its border, as a part of its size. */
const BORDER = 0.22;

const NOTHING: FeatureCollection = { type: "FeatureCollection", features: [] };

/** The map by MapLibre, drawn from this server's data alone. */
export class WebGlMap implements InsetMap {
  readonly root: HTMLElement;
  readonly #earth: Earth;
  readonly #map: maplibre.Map;
  readonly #marker: maplibre.Marker;
  readonly #cone = svg("path", { class: "cone" });
  #data: { buildings: FeatureCollection; spots: FeatureCollection } | undefined;
  #last: Pose | undefined;

  /** Fails where the browser has no WebGL. */
  constructor(box: HTMLElement, earth: Earth, pose: Pose, events: InsetMapEvents) {
    this.root = element("div", { class: "canvas" });
    box.append(this.root);
    this.#earth = earth;
    const centre = earth.toLngLat(pose.eye[0], pose.eye[1]);
    try {
      this.#map = new maplibre.Map({
        container: this.root,
        style: style(),
        center: centre,
        zoom: FIRST_ZOOM,
        maxZoom: 22,
        minZoom: 12,
        attributionControl: false,
        dragRotate: false,
        touchPitch: false,
        pitchWithRotate: false,
        fadeDuration: 0,
        // The corner has keys and buttons for any map.
        keyboard: false,
      });
    } catch (error) {
      this.root.remove();
      throw error;
    }
    this.#map.touchZoomRotate.disableRotation();
    // What can be focused is the box around it, which says what it is.
    const canvas = this.#map.getCanvas();
    canvas.tabIndex = -1;
    canvas.setAttribute("aria-hidden", "true");
    const shape = svg(
      "svg",
      { class: "here", viewBox: "-60 -60 120 120", width: 120, height: 120 },
      this.#cone,
      svg("circle", { r: 6 }),
    );
    const marker = element("div", { class: "here-box", "aria-label": TEXT.here, role: "img" });
    marker.append(shape);
    this.#marker = new maplibre.Marker({ element: marker, rotationAlignment: "map" })
      .setLngLat(centre)
      .addTo(this.#map);
    this.#map.on("load", () => this.#fill());
    this.#map.on("click", (event) => {
      const { x, y } = event.point;
      const near = this.#map.queryRenderedFeatures(
        [
          [x - NEAR_PX, y - NEAR_PX],
          [x + NEAR_PX, y + NEAR_PX],
        ],
        { layers: ["spots"] },
      );
      const panorama = near[0]?.properties.panorama;
      if (typeof panorama === "string") {
        events.goToPhotograph(panorama);
      } else {
        events.go(...earth.toScene([event.lngLat.lng, event.lngLat.lat]));
      }
    });
    this.#map.on("mousemove", "spots", () => {
      this.#map.getCanvas().style.cursor = "pointer";
    });
    this.#map.on("mouseleave", "spots", () => {
      this.#map.getCanvas().style.cursor = "";
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.#map.setStyle(style());
      this.#map.once("styledata", () => this.#fill());
    });
  }

  draw(buildings: Iterable<readonly Outline[]>, spots: readonly Spot[]): void {
    const shapes: Feature[] = [];
    for (const outlines of buildings) {
      const coordinates = outlines.map((outline) =>
        outline.map((ring) => {
          const corners = ring.map(([x, y]) => this.#earth.toLngLat(x, y));
          return [...corners, ...corners.slice(0, 1)];
        }),
      );
      const geometry = { type: "MultiPolygon" as const, coordinates };
      shapes.push({ type: "Feature", properties: {}, geometry });
    }
    const places = spots.map(({ panorama, place }): Feature => {
      const coordinates = this.#earth.toLngLat(place[0], place[1]);
      return {
        type: "Feature",
        properties: { panorama },
        geometry: { type: "Point", coordinates },
      };
    });
    this.#data = {
      buildings: { type: "FeatureCollection", features: shapes },
      spots: { type: "FeatureCollection", features: places },
    };
    this.#fill();
  }

  follow(pose: Pose, widthDeg: number): void {
    const [x, y] = pose.eye;
    const here = this.#earth.toLngLat(x, y);
    const heading = radians(pose.headingDeg);
    const ahead = this.#earth.toLngLat(x + 10 * Math.sin(heading), y + 10 * Math.cos(heading));
    const moved = !this.#last || this.#last.eye[0] !== x || this.#last.eye[1] !== y;
    this.#last = pose;
    this.#cone.setAttribute("d", conePath(widthDeg));
    this.#marker.setLngLat(here).setRotation(azimuth(here, ahead));
    if (moved && this.#isNearBorder(here)) {
      const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
      this.#map.easeTo({ center: here, duration: still ? 0 : 400 });
    }
  }

  get centre(): readonly [number, number] {
    const { lng, lat } = this.#map.getCenter();
    return this.#earth.toScene([lng, lat]);
  }

  get metresPerPixel(): number {
    const { x, y } = this.#map.project(this.#map.getCenter());
    const { lng, lat } = this.#map.unproject([x + 1, y]);
    const [u, v] = this.centre;
    const [p, q] = this.#earth.toScene([lng, lat]);
    return Math.hypot(p - u, q - v);
  }

  pan(right: number, down: number): void {
    this.#map.panBy([right, down], { duration: 0 });
  }

  zoom(factor: number): void {
    this.#map.zoomTo(this.#map.getZoom() + Math.log2(factor), { duration: 0 });
  }

  resized(): void {
    this.#map.resize();
  }

  #isNearBorder(here: LngLat): boolean {
    const { x, y } = this.#map.project(here);
    const { clientWidth: width, clientHeight: height } = this.root;
    const off = (at: number, size: number) => at < BORDER * size || at > (1 - BORDER) * size;
    return off(x, width) || off(y, height);
  }

  #fill(): void {
    const set = (name: string, data: FeatureCollection) => {
      const source = this.#map.getSource(name);
      if (source instanceof maplibre.GeoJSONSource) {
        source.setData(data);
      }
    };
    if (this.#data) {
      set("buildings", this.#data.buildings);
      set("spots", this.#data.spots);
    }
  }
}

/** Clockwise from north on the map, degrees. */
function azimuth(from: LngLat, to: LngLat): number {
  const east = (to[0] - from[0]) * Math.cos(radians(from[1]));
  return degrees(Math.atan2(east, to[1] - from[1]));
}

/** Colours are those of the page. */
function style(): maplibre.StyleSpecification {
  const colours = getComputedStyle(document.documentElement);
  const colour = (name: string) => colours.getPropertyValue(`--map-${name}`).trim() || "#888";
  return {
    version: 8,
    sources: {
      buildings: { type: "geojson", data: NOTHING },
      spots: { type: "geojson", data: NOTHING },
    },
    layers: [
      { id: "ground", type: "background", paint: { "background-color": colour("ground") } },
      {
        id: "buildings",
        type: "fill",
        source: "buildings",
        paint: { "fill-color": colour("building"), "fill-outline-color": colour("outline") },
      },
      {
        id: "spots",
        type: "circle",
        source: "spots",
        paint: {
          "circle-radius": ["interpolate", ["linear"], ["zoom"], 14, 1, 17, 2.5, 20, 5],
          "circle-color": colour("spot"),
          "circle-stroke-color": colour("ground"),
          "circle-stroke-width": 1,
        },
      },
    ],
  };
}
