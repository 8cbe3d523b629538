# Included by CMakeLists.txt: what C++ programs written for /opt/ros find there, and not beside Debian's ROS.

# The compiler looks into one folder more: ros/ from here, and a link to the headers of each message package of this
# repository. It is not the include folder of the workspace itself: CMake leaves out -I for a folder that the compiler
# searches anyway, so that a workspace configured with the hook could not be built without it.
get_filename_component(here ${CMAKE_CURRENT_SOURCE_DIR} REALPATH)
get_filename_component(repository ${here}/../../.. ABSOLUTE)
set(headers ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_SHARE_DESTINATION}/include)
file(GLOB definitions ${repository}/msg ${here}/../../*/*/msg ${here}/../../*/*/srv ${here}/../../*/*/action)
set(message_packages)
foreach(folder ${definitions})
  get_filename_component(folder ${folder} DIRECTORY)
  file(STRINGS ${folder}/package.xml name REGEX "<name>" LIMIT_COUNT 1)
  string(REGEX REPLACE ".*<name>(.*)</name>.*" "\\1" name "${name}")
  list(APPEND message_packages ${name})
endforeach()
list(REMOVE_DUPLICATES message_packages)
file(REMOVE_RECURSE ${headers})
file(MAKE_DIRECTORY ${headers})
file(CREATE_LINK ${here}/include/ros ${headers}/ros SYMBOLIC)
foreach(name ${message_packages})
  if(CATKIN_DEVEL_PREFIX MATCHES "/${PROJECT_NAME}$")  # each package has one: catkin_make_isolated, catkin build
    file(CREATE_LINK ${CATKIN_DEVEL_PREFIX}/../${name}/include/${name} ${headers}/${name} SYMBOLIC)
  else()
    file(CREATE_LINK ../../../include/${name} ${headers}/${name} SYMBOLIC)
  endif()
endforeach()

catkin_add_env_hooks(50.cpp_headers SHELLS sh DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/env-hooks)
# The links lie in the devel space
#catkin_lint: ignore external_directory
install(DIRECTORY ${headers} DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION} PATTERN ros EXCLUDE)
install(DIRECTORY include/ros DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION}/include)

# A variable of the environment switches it off, as for the env hook; an older CMake leaves it out
#catkin_lint: ignore env_var cmake_old
include(cmake/same_workspace.cmake)
