/* Debian's archives are compiled for programs (-fPIE): within a shared library the linker refuses
   their direct access to data of the C library. So the copies that the wheel is linked from have
   these three names in place of stderr, stdout and stdin. */
#include <stdio.h>

FILE *impedraw_stderr, *impedraw_stdout, *impedraw_stdin;

__attribute__((constructor)) static void set_streams(void) {
  impedraw_stderr = stderr;
  impedraw_stdout = stdout;
  impedraw_stdin = stdin;
}
