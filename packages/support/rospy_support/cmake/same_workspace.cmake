# Packages in the same workspace (./run link, catkin_make) are compiled before its setup file exists, and at the same
# time as our messages. So once all packages are configured, their programs get the folder, and wait for the messages.
function(cpp_headers_complete folder)
  get_filename_component(source ${folder} REALPATH)
  string(FIND ${source} "${CPP_HEADERS_REPOSITORY}/" place)
  if(NOT place EQUAL 0)
    get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
    foreach(target ${targets})
      get_target_property(type ${target} TYPE)
      if(type MATCHES "^(EXECUTABLE|(STATIC|SHARED|MODULE|OBJECT)_LIBRARY)$")
        target_compile_options(${target} PRIVATE
          "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-isystem ${CPP_HEADERS_HEADERS}>")
        add_dependencies(${target} ${CPP_HEADERS_MESSAGES})
      endif()
    endforeach()
  endif()
  get_property(subdirectories DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(subdirectory ${subdirectories})
    cpp_headers_complete(${subdirectory})
  endforeach()
endfunction()

function(cpp_headers_finish repository headers)
  set(CPP_HEADERS_REPOSITORY ${repository})
  set(CPP_HEADERS_HEADERS ${headers})
  set(CPP_HEADERS_MESSAGES)
  foreach(name ${ARGN})
    if(TARGET ${name}_generate_messages_cpp)
      list(APPEND CPP_HEADERS_MESSAGES ${name}_generate_messages_cpp)
    endif()
  endforeach()
  cpp_headers_complete(${CMAKE_SOURCE_DIR})
endfunction()

if(NOT "$ENV{TURTLE_ROBOTONT_CPP_HEADERS}" STREQUAL "0" AND NOT CMAKE_VERSION VERSION_LESS 3.19
    AND NOT CMAKE_SOURCE_DIR STREQUAL CMAKE_CURRENT_SOURCE_DIR)
  # EVAL, because the arguments of a deferred call are evaluated when it is made, and in the other folder
  cmake_language(EVAL CODE "cmake_language(DEFER DIRECTORY [[${CMAKE_SOURCE_DIR}]]
    CALL cpp_headers_finish [[${repository}]] [[${headers}]] ${message_packages})")
endif()
