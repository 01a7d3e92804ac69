/* The subcommands of `thrum`. argv[0] of each is its name; the table of them stands in main.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_CMD_H
#define THRUM_APP_CMD_H

int cmd_precompute(int argc, char **argv);
int cmd_convert(int argc, char **argv);
int cmd_mesh(int argc, char **argv);
int cmd_check(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_embed(int argc, char **argv);
int cmd_export(int argc, char **argv);
int cmd_simulate(int argc, char **argv);
int cmd_static(int argc, char **argv);
int cmd_experiments(int argc, char **argv);
int cmd_tradeoff(int argc, char **argv);
int cmd_bench(int argc, char **argv);
int cmd_schema(int argc, char **argv);
int cmd_view(int argc, char **argv);

#endif
