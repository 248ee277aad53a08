"""The whole body by Pinocchio: postures that realise a motion, and the loads of its joints."""
