#!/usr/bin/env bash
# package_test.sh BUILD [PYTHON]: installs what was built into a folder of its own and uses it there as
# someone would who has nothing else: program, manual, completion, both ways to find the library, Python.
set -euo pipefail
build=$1
python=${2:-}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
prefix=$scratch/usr
cmake --install "$build" --prefix "$prefix" >"$scratch/log"
lib=$(dirname "$(find "$prefix" -name libsheen.so)")
scene=$prefix/share/sheen/scenes/cornell_glossy.glb
cd "$scratch"

fail() { echo "package_test: $*" >&2; exit 1; }
step() { echo "== $*"; }

step "the program"
"$prefix/bin/sheen" render "$scene" --size 32x32 --bounces 1 -o program.exr >/dev/null
[[ -s program.exr ]] || fail "no image"

step "a manual page for each command, with each of its options"
commands=$("$prefix/bin/sheen" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
[[ $(wc -w <<<"$commands") -ge 7 ]] || fail "few commands: $commands"
for command in $commands; do
    page=$prefix/share/man/man1/sheen-$command.1
    [[ -s $page ]] || fail "no page of $command"
    for option in $("$prefix/bin/sheen" "$command" --help | grep -o '^  \(-[a-z],\)\?--[a-z-]*' | sed 's/.*--/--/'); do
        grep -qF -- "\\fB${option//-/\\-}\\fR" "$page" || fail "$page lacks $option"
    done
done
grep -qF 'Default: 512x512' "$prefix/share/man/man1/sheen-render.1" || fail "no default"

step "completion"
complete_with() {  # WORD...: what bash offers for the last one
    COMP_WORDS=("$@")
    COMP_CWORD=$(($# - 1))
    _sheen
    echo "${COMPREPLY[*]}"
}
source "$prefix/share/bash-completion/completions/sheen"
[[ $(complete_with sheen ren) == render ]] || fail "command"
[[ $(complete_with sheen render --meth) == --method ]] || fail "option"
[[ $(complete_with sheen render --method r) == "radiance reference" ]] || fail "values"
[[ $(complete_with sheen render sc) == "" ]] || fail "file names are bash's"

step "the library by pkg-config, in C"
export PKG_CONFIG_PATH=$lib/pkgconfig LD_LIBRARY_PATH=$lib
examples=$prefix/share/doc/libsheen-dev/examples
[[ $(pkg-config --modversion sheen) == $("$prefix/bin/sheen" --version | cut -d' ' -f2) ]] || fail "version"
cc "$examples/image.c" $(pkg-config --cflags --libs sheen) -o image_c
./image_c "$scene" c.exr >/dev/null
[[ -s c.exr ]] || fail "no image of C"

step "the library by find_package, in C++"
cmake -S "$examples" -B examples -G Ninja -DCMAKE_PREFIX_PATH="$prefix" >>log
cmake --build examples --target image >>log
unset LD_LIBRARY_PATH  # CMake notes where it found it
./examples/image "$scene" cpp.exr >/dev/null
cmp c.exr cpp.exr || fail "C and C++ make different images"

if [[ -n $python ]]; then
    step "the Python module"
    LD_LIBRARY_PATH=$lib PYTHONPATH=$prefix/lib/python3/dist-packages "$python" \
        "$prefix/share/doc/python3-sheen/examples/image.py" "$scene" python.exr >/dev/null
    cmp c.exr python.exr || fail "C and Python make different images"
fi
