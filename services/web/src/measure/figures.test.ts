import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { LidarPointSchema } from "../gen/flaneur/v1/render_pb";
import { GpsTimeKind, SceneSchema } from "../gen/flaneur/v1/scene_pb";
import { momentOf } from "./gps_time";
import { lasClass } from "./las_class";
import { dateOf } from "./panel";
import { referenceOf } from "./reference";

describe("the time of a point", () => {
  const moment = (gpsTime: number, gpsTimeKind: GpsTimeKind, time = "") =>
    momentOf(create(LidarPointSchema, { gpsTime, gpsTimeKind, time }));

  it("is a date where the survey counts from one", () => {
    expect(moment(399_712_818.125, GpsTimeKind.ADJUSTED, "2024-05-14T09:06:40.125Z")).toEqual({
      time: "2024-05-14 09:06:40.125 UTC",
      remark: "adjusted standard GPS time 399712818.125000 s",
    });
    const nowhen = moment(9e12, GpsTimeKind.ADJUSTED);
    expect(nowhen.time).toBe("9000000000000.000000 s");
    expect(nowhen.remark).toContain("no date");
  });

  it("is a day of a week where it counts from an unknown one", () => {
    const { time, remark } = moment(228_671.755_606_565, GpsTimeKind.WEEK);
    expect(time).toBe("Tuesday 15:31:11.755 GPS time");
    expect(remark).toContain("GPS week time 228671.755607 s");
    expect(remark).toContain("no date");
    expect(moment(0.5, GpsTimeKind.WEEK).time).toBe("Sunday 00:00:00.500 GPS time");
    expect(moment(604_799.9999, GpsTimeKind.WEEK).time).toBe("Saturday 23:59:59.999 GPS time");
  });

  it("is as it is stored where nothing else is known of it", () => {
    for (const kind of [GpsTimeKind.WEEK, GpsTimeKind.UNSPECIFIED]) {
      expect(moment(399_712_818, kind).time).toBe("399712818.000000 s");
      expect(moment(399_712_818, kind).remark).not.toBe("");
    }
    expect(moment(0, GpsTimeKind.WEEK)).toEqual({ time: "the survey has no times", remark: "" });
  });
});

describe("the time of a photograph", () => {
  it("is said with its zone", () => {
    expect(dateOf("2024-05-14T10:00:06.250Z")).toBe("2024-05-14 10:00 UTC");
    expect(dateOf("2014-06-16T12:39:01+02:00")).toBe("2014-06-16 12:39 +02:00");
    expect(dateOf("2014-06-16T12:39:01+00:00")).toBe("2014-06-16 12:39 UTC");
    expect(dateOf("")).toBe("undated");
  });
});

describe("the class of a point", () => {
  it("is said in the words of LAS", () => {
    expect(lasClass(2)).toBe("ground, class 2");
    expect(lasClass(17)).toBe("bridge deck, class 17");
    expect(lasClass(26)).toBe("reserved by LAS, class 26");
    expect(lasClass(200)).toBe("defined by the survey, class 200");
  });
});

describe("what coordinates refer to", () => {
  it("is a CRS by name and code, or the survey's own metres", () => {
    const of = (crs: string, more = {}) => referenceOf(create(SceneSchema, { crs, ...more }));
    expect(of("EPSG:2154", { crsName: "RGF93 / Lambert-93" })).toBe(
      "RGF93 / Lambert-93 (EPSG:2154): east, north, height in metres; the survey does not name what heights count from",
    );
    expect(of("EPSG:2154")).toMatch(/^EPSG:2154: .*heights count from$/);
    const compound = of("EPSG:7415", { crsName: "Amersfoort / RD New + NAP height" });
    expect(compound).toMatch(/in metres$/);
    expect(of("local")).toContain("own metres");
    const geographicOrigin = { latitudeDeg: 49, longitudeDeg: 8.4, heightM: 110 };
    expect(of("local", { geographicOrigin })).toContain("49.00000000, 8.40000000 (WGS84)");
  });
});
