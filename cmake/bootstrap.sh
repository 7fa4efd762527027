# Sourced by ./sheen, ./check and .ci/run: installs what is missing and builds, and does neither
# when nothing has changed. Everything it says goes to stderr: stdout belongs to the program.

packages=(
    g++ cmake ninja-build pkg-config
    libosmesa6-dev libegl-dev libglm-dev libfmt-dev libtbb-dev libembree-dev
    libopenexr-dev libopencolorio-dev libpng-dev libturbojpeg0-dev libwebp-dev libtinygltf-dev libmeshoptimizer-dev libdraco-dev libnanoflann-dev libstb-dev libxxhash-dev libmurmurhash-dev libglfw3-dev libimgui-dev libcli11-dev nlohmann-json3-dev
    libjs-chart.js
)
# What CMake asks for where tests and benchmarks are built too.
test_build_packages=(libgtest-dev libbenchmark-dev pybind11-dev python3-dev libopenmpi-dev)
# What only ./check needs: the browser that opens the chart's report, plots of the benchmarks, a window
# system's server, arrays of the Python module, what starts ranks.
test_packages=(chromium chromium-driver python3-selenium gnuplot-nox xvfb xdotool python3-xlib python3-pil python3-numpy openmpi-bin)
build="$root/build/release"
log="$root/build/build.log"

say() { echo "sheen: $*" >&2; }

# install_packages PACKAGE...: those that are missing; exits 4 where that needs another user.
install_packages() {
    command -v dpkg-query >/dev/null || return 0  # not Debian: CMake will name what it misses
    local installed missing=() package
    installed=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' "$@" 2>/dev/null || true)
    for package in "$@"; do
        grep -qxF "$package installed" <<<"$installed" || missing+=("$package")
    done
    [[ ${#missing[@]} -gt 0 ]] || return 0
    if [[ $(id -u) -ne 0 ]]; then
        say "error: Debian packages are missing; run: sudo apt-get install ${missing[*]}"
        exit 4
    fi
    say "installing Debian packages: ${missing[*]}"
    local install=(apt-get install -y -qq --no-install-recommends "${missing[@]}")
    export DEBIAN_FRONTEND=noninteractive
    # Package lists may be absent or out of date.
    if ! "${install[@]}" >"$log" 2>&1 </dev/null &&
        ! { apt-get update -qq && "${install[@]}"; } >>"$log" 2>&1 </dev/null; then
        tail -n 30 "$log" >&2
        say "error: apt-get failed; the whole log is in $log"
        exit 4
    fi
}

# A folder's own time changes when files in it come or go, so that those are noticed as well.
sources_unchanged_since() {
    [[ -e $1 ]] || return 1
    local changed
    changed=$(cd "$root" && find CMakeLists.txt CMakePresets.json cmake include src shaders scenes python examples bench tests \
        -newer "$1" -print -quit 2>&1)
    [[ -z $changed ]]
}

# Whether a target lies in tests/ or bench/, or everything is asked for.
needs_tests() { [[ $1 != sheen && $1 != make_scenes ]]; }

# configure_and_build TARGET
configure_and_build() {
    cd "$root"
    local cache="$build/CMakeCache.txt" fresh=() tests=OFF
    ! needs_tests "$1" || tests=ON
    # A tree that was moved or copied must forget its old place.
    if [[ -e $cache ]] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" "$cache"; then
        fresh=(--fresh)
    fi
    if [[ ! -e $build/build.ninja || ${#fresh[@]} -gt 0 ]] ||
        { [[ $tests == ON ]] && grep -qxF "SHEEN_TESTS:BOOL=OFF" "$cache"; }; then
        cmake --preset release "${fresh[@]}" -DSHEEN_TESTS=$tests -DSHEEN_PYTHON=$tests -DSHEEN_MPI=$tests
    fi
    cmake --build "$build" --target "$1"
}

# ensure_built TARGET: up to date when it returns; exits 1 where the build fails, 4 where packages
# are missing. Any number of calls may run at once: one builds, the others wait for it.
ensure_built() {
    local stamp="$build/.built-$1" known_packages="$root/build/.packages"
    sources_unchanged_since "$stamp" && return 0
    mkdir -p "$build"
    exec 9>"$root/build/.lock"
    flock 9
    if ! sources_unchanged_since "$stamp"; then
        # What ./check configured stays configured.
        if needs_tests "$1" || grep -qsx 'SHEEN_TESTS:BOOL=ON' "$build/CMakeCache.txt"; then
            packages+=("${test_build_packages[@]}")
        fi
        if [[ "$(cat "$known_packages" 2>/dev/null)" != "${packages[*]}" ]]; then
            install_packages "${packages[@]}"
            echo "${packages[*]}" >"$known_packages"
        fi
        if [[ -e $build/build.ninja ]]; then
            say "sources changed: building"
        else
            say "first build: this takes some minutes (log: $log)"
        fi
        # The stamp's time is that of the start: what changes during the build is built next time.
        touch "$stamp.new"
        if ! (configure_and_build "$1") >"$log" 2>&1 9>&- </dev/null; then
            rm -f "$stamp.new" "$known_packages"
            tail -n 60 "$log" >&2
            say "error: the build failed; the whole log is in $log"
            exit 1
        fi
        mv "$stamp.new" "$stamp"
    fi
    exec 9>&-
}
