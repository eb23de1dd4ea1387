"""impedraw"""
