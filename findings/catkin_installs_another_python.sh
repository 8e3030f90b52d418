#!/bin/sh
# catkin 0.8.10 (Debian 12): a script that catkin_install_python() installs runs on another Python in the
# install space than in the devel space. There it gets a wrapper that names PYTHON_EXECUTABLE in full;
# when it is installed, only "env python" becomes "env" and the *name* of that executable, and "env
# python3" stays as it is. So a workspace that was built for /usr/bin/python3 runs on the python3 of
# pyenv or conda once it is installed, where that is first on PATH: often without rospy.
# Seen: the first lines of "one" (env python) and "two" (env python3) in devel and in install.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get download -qq catkin=0.8.10-9 python3-catkin=0.8.10-9 python3-catkin-pkg=0.5.2-5 \
    python3-empy=3.3.4-2 python3-pyparsing python3-docutils python3-dateutil python3-six 2> /dev/null
for package in *.deb; do dpkg -x "$package" .; done
export PYTHONPATH="$folder/usr/lib/python3/dist-packages"
export PATH="$folder/usr/bin:/usr/bin:/bin"
mkdir package
cat > package/package.xml <<'END'
<package format="2">
  <name>finding</name>
  <version>0.1.0</version>
  <description>Two scripts.</description>
  <maintainer email="nobody@example.org">nobody</maintainer>
  <license>BSD</license>
  <buildtool_depend>catkin</buildtool_depend>
</package>
END
cat > package/CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.10)
project(finding)
find_package(catkin REQUIRED)
catkin_package()
catkin_install_python(PROGRAMS one two DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
END
printf '#!/usr/bin/env python\nprint("one")\n' > package/one
printf '#!/usr/bin/env python3\nprint("two")\n' > package/two
chmod +x package/one package/two
cmake -S package -B build -DPYTHON_EXECUTABLE=/usr/bin/python3 -DCATKIN_ENABLE_TESTING=OFF \
    -Dcatkin_DIR="$folder/usr/share/catkin/cmake" -DCMAKE_PREFIX_PATH="$folder/usr" \
    -DEMPY_EXECUTABLE="$folder/usr/bin/empy" -DCATKIN_DEVEL_PREFIX="$folder/devel" \
    -DCMAKE_INSTALL_PREFIX="$folder/install" > cmake.txt 2>&1 || { cat cmake.txt; exit 1; }
cmake --build build --target install >> cmake.txt 2>&1 || { cat cmake.txt; exit 1; }
seen=$(head -qn1 devel/lib/finding/one devel/lib/finding/two install/lib/finding/one \
    install/lib/finding/two)
echo "$seen"
[ "$seen" = '#!/usr/bin/python3
#!/usr/bin/python3
#!/usr/bin/env python3
#!/usr/bin/env python3' ]
