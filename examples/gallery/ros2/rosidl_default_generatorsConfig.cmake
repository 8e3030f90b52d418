# What the tests have for their interfaces, and the packages that those of the gallery depend on besides.
get_filename_component(here ${CMAKE_CURRENT_LIST_FILE} REALPATH)
get_filename_component(root ${here} DIRECTORY)
set(tests ${root}/../../../robosc_ros1/test/ros2)
include(${tests}/interfaces/rosidl_default_generatorsConfig.cmake)
foreach(dependency geometry_msgs trajectory_msgs)
  find_package(${dependency} REQUIRED)
  set_target_properties(${dependency}::${dependency}__rosidl_generator_py
    PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "")
endforeach()
