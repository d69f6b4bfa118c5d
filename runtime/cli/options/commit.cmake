# Writes the commit of the sources into OUTPUT, if it is another one: cmake -DSOURCE=… -DOUTPUT=… -P commit.cmake
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define CDB_COMMIT \"${commit}\"\n")
