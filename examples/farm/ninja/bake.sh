#!/usr/bin/env bash
# Bakes with Ninja: plans again if meshes were added or removed, then runs what has changed.
#
#   bake.sh MESHES PACKS
set -euo pipefail

bake farm plan "$1" --out "$2" --batch 64 --emit ninja >build.ninja.new
# Ninja starts edges again whose text has changed, so an equal plan changes nothing.
if cmp -s build.ninja.new build.ninja; then rm build.ninja.new; else mv build.ninja.new build.ninja; fi
exec ninja
