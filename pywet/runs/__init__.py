"""Run directories: conversion of raw files to tables, reading, and the schema of their JSON files."""
