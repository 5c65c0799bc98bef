/* SPDX-License-Identifier: BSD-3-Clause */
// the search reads its excerpts from the pages, which browsers do not allow it on pages opened from a disk
if (location.protocol === "file:") DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
