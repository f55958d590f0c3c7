#!/bin/sh
# demo.sh FLANEUR FOLDER LISTEN [ONCE]: a street from nothing to a picture, as a person would do it.
set -eu
flaneur=$1
folder=$2
listen=$3
once=${4:-}
# On the road, between the places where photographs were taken, looking down the street.
view=651507.5,6861077,44.6,39,2

mkdir -p "$folder"
# street.toml is written last, so a street that has one is whole.
if [ ! -f "$folder/street/street.toml" ]; then
    rm -rf "$folder/street"
    "$flaneur" sample "$folder/street"
fi
"$flaneur" ingest "$folder/street" --out "$folder/store"

"$flaneur" serve "$folder/store" --listen "$listen" >"$folder/serve.out" &
server=$!
trap 'kill "$server" 2>/dev/null || :; wait "$server" 2>/dev/null || :' EXIT
# Ctrl-C is how the demo ends.
trap 'exit 0' INT TERM

url=""
for _ in $(seq 100); do
    url=$(sed -n 's/.*\(http:\/\/[^ ]*\).*/\1/p' "$folder/serve.out" | head -n 1)
    [ -z "$url" ] || break
    kill -0 "$server" 2>/dev/null || { echo "demo: the server did not start; see the lines above" >&2; exit 1; }
    sleep 0.1
done
[ -n "$url" ] || { echo "demo: the server printed no address within 10 s" >&2; exit 1; }

"$flaneur" render "$url/sample" --view "$view" --out "$folder/frame.png" --report "$folder/frame.json"

echo
echo "picture: $folder/frame.png   (report: $folder/frame.json)"
echo "walk:    $url   (in a browser)"
echo "serving: $url   (gRPC, gRPC-Web, reflection; $url/metrics)"
if [ -z "$once" ]; then
    echo "Ctrl-C ends it"
    wait "$server"
fi
