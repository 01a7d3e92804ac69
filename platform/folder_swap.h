/* Folders that take each other's place, and folders that one process at a time works in.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_FOLDER_SWAP_H
#define THRUM_PLATFORM_FOLDER_SWAP_H

/* Exchanges the folders at two paths of one file system, in one step where the system can do that.
 * Elsewhere by way of the free path `spare`: a process that is killed meanwhile leaves the folder
 * of `first` there. Returns 0, or the errno of the failure; then both are where they were. */
int thrum_folder_swap(const char *first, const char *second, const char *spare);

/* Opens a folder and locks it until the descriptor is closed or the process ends. Returns the
 * descriptor, or -1 with errno: EWOULDBLOCK where another process has the lock. */
int thrum_folder_lock(const char *path);

/* The path of an existing folder or file without links, for free(); NULL with errno on failure. */
char *thrum_folder_real_path(const char *path);

/* Lets the names in a folder survive a power cut. Returns 0, also where the file system cannot sync
 * folders or this one may not be read, or the errno of the failure. */
int thrum_folder_sync(const char *path);

#endif
