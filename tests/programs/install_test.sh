#!/bin/sh
# install_test.sh BUILD: installs the build into a fresh prefix, reads an OpenVDB grid with it, with and without the module
# that does, then builds and runs a host against it, once by find_package and once by pkg-config.
set -eu

build=$1
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" >"$work/install.log" || { cat "$work/install.log"; exit 1; }
for program in bake play inspect reference compare tetrahedra; do
    "$work/prefix/bin/airlight-$program" --version
done

cd "$work"
"$build/bin/vdb_speck" grid.vdb 4 1 2 1
cat >scene.json <<JSON
{
  "media": [{"name": "smoke", "density": {"type": "grid", "file": "grid.vdb"}, "sigma_s_per_m": 1}],
  "fogs": ["smoke"]
}
JSON
prefix/bin/airlight-bake scene.json -o baked --plan
rm "$(find prefix -name libairlight_vdb.so)"
code=0
prefix/bin/airlight-bake scene.json -o baked --plan 2>said || code=$?
cat said
[ "$code" = 4 ] && [ "$(wc -l <said)" = 1 ] && grep -q 'grid.vdb: needs OpenVDB: .*libairlight_vdb.so' said ||
    { echo "FAIL without the module: exit code $code"; exit 1; }

cmake -G Ninja -S "$here/consumer" -B package -DCMAKE_PREFIX_PATH="$work/prefix"
cmake --build package
package/consumer

pc=$(dirname "$(find "$work/prefix" -name airlight-runtime.pc)")
export PKG_CONFIG_PATH="$pc"
# shellcheck disable=SC2046
${CC:-cc} "$here/consumer/consumer.c" $(pkg-config --define-variable=prefix="$work/prefix" --cflags --libs \
    airlight-runtime) -o by_pkg_config
./by_pkg_config
