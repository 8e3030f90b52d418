# The wheels lack the glue that find_package(rosidl_default_generators) is on an installed ROS 2: here
# are its parts. What else they miss are the empty packages that ros2_support.py makes.

# Typesupport libraries are loaded by name at run time.
set(BUILD_SHARED_LIBS ON)
find_package(Python3 REQUIRED COMPONENTS Interpreter Development NumPy)
# In the order in which they need one another: the one of fastrtps before the one that chooses.
foreach(generator
    rosidl_cmake rosidl_typesupport_fastrtps_c rosidl_generator_type_description
    rosidl_generator_c rosidl_typesupport_c rosidl_generator_py)
  find_package(${generator} REQUIRED)
endforeach()

foreach(dependency
    action_msgs builtin_interfaces service_msgs std_msgs unique_identifier_msgs)
  find_package(${dependency} REQUIRED)
  # These name folders of the machine on which the wheels were built.
  set_target_properties(${dependency}::${dependency}__rosidl_generator_py
    PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "")
endforeach()

# Nothing here is written in C++, and what would be generated for it takes almost as long to compile
# as all the rest.
list(FILTER AMENT_EXTENSIONS_rosidl_generate_idl_interfaces EXCLUDE REGEX "_cpp:")
