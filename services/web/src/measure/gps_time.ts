import type { LidarPoint } from "../gen/flaneur/v1/render_pb";
import { GpsTimeKind } from "../gen/flaneur/v1/scene_pb";
import { TEXT } from "../strings";

const DAY_S = 86_400;
const WEEK_S = 7 * DAY_S;

/** When a point was measured, as far as its survey says: the time to read, and what it was made from. */
export interface Moment {
  readonly time: string;
  readonly remark: string;
}

export function momentOf({ gpsTime, gpsTimeKind, time }: LidarPoint): Moment {
  const stored = `${gpsTime.toFixed(6)} s`;
  if (gpsTime === 0) {
    return { time: TEXT.untimed, remark: "" };
  }
  switch (gpsTimeKind) {
    case GpsTimeKind.ADJUSTED:
      return time
        ? { time: utc(time), remark: TEXT.adjustedTime(stored) }
        : { time: stored, remark: TEXT.adjustedWithoutDate };
    case GpsTimeKind.WEEK:
      return gpsTime > 0 && gpsTime < WEEK_S
        ? { time: ofWeek(gpsTime), remark: TEXT.weekTime(stored) }
        : { time: stored, remark: TEXT.noWeekTime };
    default:
      return { time: stored, remark: TEXT.unknownTime };
  }
}

/** An RFC 3339 time in UTC, to be read. */
function utc(time: string): string {
  return `${time.replace("T", " ").replace(/Z$/, "")} UTC`;
}

/** A second of a week that begins on Sunday, as its day and the time of that day. */
function ofWeek(second: number): string {
  const day = TEXT.days[Math.floor(second / DAY_S)] ?? "";
  const milliseconds = Math.floor((second % DAY_S) * 1000);
  // A date is not said; the time of the day is the same on each.
  return TEXT.weekDay(day, new Date(milliseconds).toISOString().slice(11, 23));
}
