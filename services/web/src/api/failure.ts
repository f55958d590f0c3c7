import { fromBinary } from "@bufbuild/protobuf";
import { BinaryReader, WireType } from "@bufbuild/protobuf/wire";
import { DurationSchema } from "@bufbuild/protobuf/wkt";
import { Code, ConnectError } from "@connectrpc/connect";
import { TEXT } from "../strings";

const RETRY_INFO = "google.rpc.RetryInfo";

/** What a failed call says of the server: it has no room, it has trouble, or nothing was heard of it. */
export type FailureKind = "full" | "trouble" | "lost";

export function failureOf(error: ConnectError): FailureKind {
  if (!answered(error)) {
    return "lost";
  }
  return error.code === Code.ResourceExhausted ? "full" : "trouble";
}

/** Whether a server has said that: other errors come from the browser, or from a proxy. */
export function answered(error: ConnectError): boolean {
  return error.metadata.has("grpc-status");
}

/** After how long the server would have the call tried again, milliseconds; undefined where it does not say. */
export function retryDelayMs(error: ConnectError): number | undefined {
  for (const detail of error.details) {
    if ("type" in detail && detail.type === RETRY_INFO) {
      return delayOf(detail.value);
    }
  }
  return undefined;
}

/** What to tell a person of what failed; of a call what the server said, or that it said nothing. */
export function reasonOf(thrown: unknown): string {
  if (!(thrown instanceof ConnectError)) {
    return thrown instanceof Error ? thrown.message : String(thrown);
  }
  if (answered(thrown)) {
    return thrown.rawMessage;
  }
  return thrown.code === Code.DeadlineExceeded ? TEXT.noAnswer : TEXT.noConnection;
}

/** `google.protobuf.Duration retry_delay = 1` of the message. */
function delayOf(message: Uint8Array): number | undefined {
  try {
    const reader = new BinaryReader(message);
    while (reader.pos < reader.len) {
      const [field, type] = reader.tag();
      if (field === 1 && type === WireType.LengthDelimited) {
        const { seconds, nanos } = fromBinary(DurationSchema, reader.bytes());
        return Math.max(Number(seconds) * 1e3 + nanos / 1e6, 0);
      }
      reader.skip(type, field);
    }
  } catch {
    // What cannot be read says nothing.
  }
  return undefined;
}
