# Further links of a worker, with its object files in other orders (runtime/manual/noise.md): the order decides where
# functions lie, and so which of them share rows of caches and of branch predictors.
# As a script, writes the list of one link:
# cmake -DOBJECTS=FILE -DBUILD=FOLDER -DORDER=1 -DOUTPUT=FILE -P link_orders.cmake
if(CMAKE_SCRIPT_MODE_FILE)
  file(READ ${OBJECTS} objects)
  list(FILTER objects INCLUDE REGEX "\\.o(bj)?$") # not a precompiled header
  list(SORT objects)
  set(keyed)
  foreach(object IN LISTS objects)
    # The order depends on its number and the sources, and not on the folder of the build.
    file(RELATIVE_PATH name ${BUILD} ${object})
    string(SHA256 key "${ORDER} ${name}")
    list(APPEND keyed "${key} ${object}")
  endforeach()
  list(SORT keyed)
  list(TRANSFORM keyed REPLACE "^[0-9a-f]+ (.*)$" "\"\\1\"")
  list(JOIN keyed "\n" lines)
  file(WRITE ${OUTPUT} "${lines}\n")
  return()
endif()

# cdb_link_orders(<worker> OBJECTS <targets that are linked into it> LIBRARIES <as of the worker>)
function(cdb_link_orders worker)
  cmake_parse_arguments(ARG "" "" "OBJECTS;LIBRARIES" ${ARGN})
  # Those of an earlier, larger number would not be built again.
  file(GLOB earlier ${CMAKE_BINARY_DIR}/${worker}-link*)
  foreach(link IN LISTS earlier)
    string(REGEX REPLACE ".*-link" "" number ${link})
    if(number GREATER CDB_LINK_ORDERS)
      file(REMOVE ${link})
    endif()
  endforeach()
  if(CDB_LINK_ORDERS LESS 1)
    return()
  endif()
  list(TRANSFORM ARG_OBJECTS REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>")
  set(objects ${CMAKE_CURRENT_BINARY_DIR}/${worker}.objects)
  file(GENERATE OUTPUT ${objects} CONTENT "${ARG_OBJECTS}")
  foreach(order RANGE 1 ${CDB_LINK_ORDERS})
    set(link ${worker}-link${order})
    set(ordered ${CMAKE_CURRENT_BINARY_DIR}/${link}.objects)
    add_custom_command(OUTPUT ${ordered}
      COMMAND ${CMAKE_COMMAND} -DOBJECTS=${objects} -DBUILD=${CMAKE_BINARY_DIR} -DORDER=${order} -DOUTPUT=${ordered}
              -P ${CMAKE_CURRENT_FUNCTION_LIST_FILE}
      DEPENDS ${objects} ${CMAKE_CURRENT_FUNCTION_LIST_FILE} VERBATIM)
    # The listed objects come before the libraries, of which nothing is then left to be linked.
    add_executable(${link} $<TARGET_OBJECTS:${worker}> ${ordered})
    set_target_properties(${link} PROPERTIES LINKER_LANGUAGE CXX LINK_DEPENDS ${ordered})
    target_link_options(${link} PRIVATE @${ordered})
    target_link_libraries(${link} PRIVATE ${ARG_LIBRARIES})
  endforeach()
endfunction()
